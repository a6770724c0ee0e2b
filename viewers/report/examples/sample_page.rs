//! Fits a CSV capture and writes its page:
//! `cargo run --release -p report --example sample_page -- CAPTURE.csv PAGE.html [TRUTH.toml]`.
#![allow(clippy::print_stdout, reason = "an example speaks to its user")]

use std::path::Path;

use anyhow::Context as _;
use identification::{FitOptions, Samples, fit};
use report::{CaptureFacts, FitPage, fit_page};

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [capture, out, truth @ ..] = arguments.as_slice() else {
        anyhow::bail!("give the capture (CSV) and the page (HTML), and the true model (TOML) if it is known");
    };
    let truth = truth.first().map(|path| dynamics::Model::load(Path::new(path))).transpose()?;
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
    let duration_s = samples.t_s.last().unwrap_or(&0.0) - samples.t_s.first().unwrap_or(&0.0);
    let source = Path::new(capture).file_name().unwrap_or_default().to_string_lossy().into_owned();
    let html = fit_page(&FitPage {
        fit: &fit,
        capture: CaptureFacts {
            title: truth.as_ref().map_or_else(|| source.clone(), |model| model.name.clone()),
            source,
            rate_hz: fit.preparation.rate_hz,
            duration_s,
            samples: samples.t_s.len() as u64,
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            ..CaptureFacts::default()
        },
        truth: truth.as_ref(),
    });
    std::fs::write(out, &html)?;
    println!("{out}: {} rows, {} bytes", fit.rows, html.len());
    Ok(())
}
