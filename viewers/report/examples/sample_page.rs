//! Fits CSV captures and writes their page, that of the mean if there are several:
//! `cargo run --release -p report --example sample_page -- PAGE.html CAPTURE.csv… [TRUTH.toml]`.
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

use std::path::Path;

use anyhow::Context as _;
use dynamics::Model;
use identification::{Fit, FitOptions, Samples, average, fit};
use report::{AveragePage, CaptureFacts, FitPage, average_page, fit_page};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, files @ ..] = arguments.as_slice() else {
        anyhow::bail!("give the page (HTML), the captures (CSV), and the true model (TOML) if it is known");
    };
    let (models, captures): (Vec<&String>, Vec<&String>) = files.iter().partition(|path| path.ends_with(".toml"));
    let truth = models.first().map(|path| Model::load(Path::new(path))).transpose()?;
    let fitted: Vec<(Fit, CaptureFacts)> =
        captures.iter().map(|path| fitted(path, truth.as_ref())).collect::<anyhow::Result<_>>()?;
    let (fits, facts): (Vec<Fit>, Vec<CaptureFacts>) = fitted.into_iter().unzip();
    let html = match (fits.as_slice(), facts.as_slice()) {
        ([fit], [capture]) => fit_page(&FitPage { fit, capture: capture.clone(), truth: truth.as_ref() }),
        _ => {
            let average = average(&fits).context("give at least one capture")?;
            average_page(&AveragePage { average: &average, fits: &fits, captures: facts, truth: truth.as_ref() })
        }
    };
    std::fs::write(out, &html)?;
    println!("{out}: {} captures, {} bytes", fits.len(), html.len());
    Ok(())
}

/// A capture's fit and what is known of it.
fn fitted(capture: &str, truth: Option<&Model>) -> anyhow::Result<(Fit, CaptureFacts)> {
    let mut reader = csv::Reader::from_path(capture).with_context(|| format!("{capture} cannot be read"))?;
    let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let mut columns = vec![Vec::new(); header.len()];
    for row in reader.records() {
        for (column, value) in columns.iter_mut().zip(row?.iter()) {
            column.push(value.parse::<f64>()?);
        }
    }
    let column = |name: &str| header.iter().position(|found| found == name).map(|index| columns[index].as_slice());
    let required = |name: &str| column(name).with_context(|| format!("{capture} has no column {name}"));
    let samples = Samples {
        t_s: required("t_s")?,
        angle_rad: required("angle_rad")?,
        velocity_rad_s: column("velocity_rad_s"),
        acceleration_rad_s2: column("acceleration_rad_s2"),
        torque_mnm: required("torque_mnm")?,
    };
    let fit = fit(&samples, &FitOptions::default())?;
    let source = Path::new(capture).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let facts = CaptureFacts {
        title: truth.map_or_else(|| source.clone(), |model| model.name.clone()),
        source,
        rate_hz: fit.preparation.rate_hz,
        duration_s: samples.t_s.last().unwrap_or(&0.0) - samples.t_s.first().unwrap_or(&0.0),
        samples: samples.t_s.len() as u64,
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
        ..CaptureFacts::default()
    };
    Ok((fit, facts))
}
