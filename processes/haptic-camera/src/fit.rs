//! `fit`: from a capture to a model.

use std::path::{Path, PathBuf};

use analysis::{AverageResult, FitResult, common_truth, titles};
use anyhow::Context as _;
use archive::whole_file::Replace;
use clap::Args;
use dynamics::Model;
use identification::{Fit, MeasuredCurve, PreparationMethod};
use loaded_capture::LoadedCapture;
use report::{AveragePage, FigureNumbers};

use crate::command_line::ColumnOptions;
use crate::harmonic_table::harmonic_table;
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::{Kind, replace, to_output, write, write_json_on};
use crate::parameter_table::{parameter_table, reasons};
use crate::repeatability::{agreement_line, repeatability_table};

/// Options of `fit`.
#[derive(Debug, Args)]
pub struct FitOptions {
    /// The capture: an archive, a CSV or an MDF file; several of the same knob give one model
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the fitted model
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the fitted parameters into a joint of this MuJoCo model, changing the file: armature, damping, frictionloss, detents
    #[arg(long, value_name = "MUJOCO.xml")]
    pub into: Option<PathBuf>,
    /// The joint's name [default: the only one]
    #[arg(long, requires = "into", value_name = "NAME")]
    pub joint: Option<String>,
    /// Measure the torque over the angle point by point instead of fitting detents; linear controls are always fitted this way
    #[arg(long)]
    pub characteristic: bool,
    /// How the capture is filtered before the fit
    #[arg(long, value_enum, default_value = "automatic")]
    pub preparation: Preparation,
}

/// How a capture is filtered before a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preparation {
    /// Every cut-off frequency from the signals' own spectra.
    Automatic,
    /// As Swindells and MacLean 2007 did.
    Paper,
    /// Angle through a 100 Hz Butterworth low-pass, differenced twice, decimated to 100 Hz: common for robots.
    CentralDifferences,
}

impl From<Preparation> for identification::PreparationMethod {
    fn from(preparation: Preparation) -> Self {
        match preparation {
            Preparation::Automatic => Self::Automatic,
            Preparation::Paper => Self::Paper,
            Preparation::CentralDifferences => Self::CentralDifferences,
        }
    }
}

/// Fits a capture and writes what was asked for.
///
/// # Errors
/// One sentence on what is wrong with the capture or a file.
pub fn run(options: &FitOptions) -> anyhow::Result<Outcome> {
    match options.captures.as_slice() {
        [capture] => fit_one(capture, options),
        captures => fit_several(captures, options),
    }
}

fn fit_one(capture: &Path, options: &FitOptions) -> anyhow::Result<Outcome> {
    let loaded = load::load_measured(capture, &options.columns)?;
    let fit = fit_as_asked(&loaded, options)?;
    if !to_output(options.json.as_deref()) {
        show(&loaded, &fit);
    }
    let page = options.report.as_ref().map(|_| analysis::fit_page(&loaded, &fit));
    let (page, figures) = page.unwrap_or_default();
    write_numbers(options.json.as_deref(), &loaded, &fit, figures)?;
    if let Some(path) = &options.out {
        write(path, Kind::FittedModel, &fit.model(&analysis::title(&loaded)).to_toml())?;
    }
    write_into(options, &fit.model(&analysis::title(&loaded)))?;
    if let Some(path) = &options.report {
        write(path, Kind::Page, &page)?;
    }
    Ok(Outcome::Done)
}

fn fit_as_asked(loaded: &LoadedCapture, options: &FitOptions) -> anyhow::Result<Fit> {
    let usual = analysis::fit_options(loaded);
    let characteristic = options.characteristic || usual.characteristic;
    Ok(analysis::fit_with(
        loaded,
        &identification::FitOptions { characteristic, preparation: options.preparation.into(), ..usual },
    )?)
}

/// One model of several captures of the same knob.
fn fit_several(captures: &[PathBuf], options: &FitOptions) -> anyhow::Result<Outcome> {
    let loaded =
        captures.iter().map(|path| load::load_measured(path, &options.columns)).collect::<anyhow::Result<Vec<_>>>()?;
    let fits = loaded.iter().map(|one| fit_as_asked(one, options)).collect::<anyhow::Result<Vec<Fit>>>()?;
    let average = identification::average(&fits).context("there is no capture to fit")?;
    let each: Vec<&LoadedCapture> = loaded.iter().collect();
    let truth = common_truth(&each);
    if !to_output(options.json.as_deref()) {
        show_fit(truth, &average.fit);
        if let Some(agreement) = average.agreement {
            say(agreement_line(agreement));
        }
        say("");
        say(repeatability_table(&average));
    }
    write_json_on(average.fit.axis, options.json.as_deref(), &AverageResult::of(&average, &each, &fits))?;
    if let Some(path) = &options.out {
        write(path, Kind::FittedModel, &average.model(&titles(&each)).to_toml())?;
    }
    write_into(options, &average.model(&titles(&each)))?;
    if let Some(path) = &options.report {
        let captures = loaded.iter().map(analysis::facts).collect();
        let page = report::average_page(&AveragePage { average: &average, fits: &fits, captures, truth });
        write(path, Kind::Page, &average.fit.axis.words(&page))?;
    }
    Ok(Outcome::Done)
}

/// Writes the model into a joint of a MuJoCo file, if that was asked for.
fn write_into(options: &FitOptions, model: &Model) -> anyhow::Result<()> {
    let Some(path) = &options.into else { return Ok(()) };
    let file = foreign_files::read_text(path).with_context(|| format!("{} cannot be read", path.display()))?;
    let changed = simulators::into_mjcf(&file, options.joint.as_deref(), model)
        .with_context(|| format!("the fitted parameters cannot be written into {}", path.display()))?;
    replace(path, Replace::Anything, &changed)?;
    say(format!(
        "{}: armature, damping, frictionloss and detents; the armature is the whole inertia, so give the body almost \
         none",
        path.display()
    ));
    Ok(())
}

/// Writes every number of a fit as JSON to a file, or to standard output for `-`; `figures` are those in a page's captions.
///
/// # Errors
/// When the file cannot be written.
pub fn write_numbers(
    path: Option<&Path>,
    loaded: &LoadedCapture,
    fit: &Fit,
    figures: FigureNumbers,
) -> anyhow::Result<()> {
    write_json_on(fit.axis, path, &FitResult::of(loaded, fit, figures))
}

/// Fits a capture with all that is known of its rig.
///
/// # Errors
/// Why it cannot be fitted, in one sentence.
pub fn fit_capture(loaded: &LoadedCapture) -> anyhow::Result<Fit> {
    Ok(analysis::fit(loaded, PreparationMethod::default())?)
}

/// Prints the fit for people.
pub fn show(loaded: &LoadedCapture, fit: &Fit) {
    show_fit(loaded.truth.as_ref(), fit);
}

fn show_fit(truth: Option<&Model>, fit: &Fit) {
    let say = |text: &dyn std::fmt::Display| say(fit.axis.words(&text.to_string()));
    say(&parameter_table(fit, truth));
    let decimals = decimals(fit.mean_ci95_mnm);
    say(&format!(
        "residual {:.decimals$} mNm RMS, {:.2} % of the torque; mean 95 % interval ±{:.decimals$} mNm",
        fit.residual_rms_mnm, fit.relative_error_percent, fit.mean_ci95_mnm
    ));
    for curve in &fit.characteristics {
        say(&characteristic_line(curve));
    }
    if let Some(table) = harmonic_table(fit) {
        say(&"");
        say(&table);
    }
    for line in reasons(fit).iter().chain(&fit.notes) {
        say(&format!("- {line}"));
    }
}

/// Three decimals, or as many as show a small number.
fn decimals(value: f64) -> usize {
    if value > 0.0 && value < 0.005 { 5 } else { 3 }
}

/// A measured curve in a line; its points are in the JSON and in the model file.
fn characteristic_line(MeasuredCurve { effect, points }: &MeasuredCurve) -> String {
    let torques = || points.iter().map(|point| point.torque_mnm);
    let halves = points.iter().filter_map(|point| point.ci95).map(|[low, high]| 0.5 * (high - low));
    let widest = halves.fold(0.0, f64::max);
    let decimals = decimals(widest);
    format!(
        "{effect}: {} points, {:.decimals$} to {:.decimals$} mNm, each known to ±{widest:.decimals$} mNm or better",
        points.len(),
        torques().fold(f64::INFINITY, f64::min),
        torques().fold(f64::NEG_INFINITY, f64::max),
    )
}
