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
use crate::fit_tables::{agreement_line, harmonic_table, parameter_table, reasons, repeatability_table};
use crate::load;
use crate::outcome::{Outcome, is_output_json, say};
use crate::outputs::{kind, write, write_if_asked, write_json_on};

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

/// Fits a capture, or one model to several captures of the same knob, and writes what was asked for.
///
/// # Errors
/// One sentence on what is wrong with a capture or a file.
pub fn run(options: &FitOptions) -> anyhow::Result<Outcome> {
    let captures = options.captures.iter().map(|path| load::load_measured(path, &options.columns));
    let captures = captures.collect::<anyhow::Result<Vec<_>>>()?;
    let fits = captures.iter().map(|one| fit_as_asked(one, options)).collect::<anyhow::Result<Vec<Fit>>>()?;
    let (model, page) = match (captures.as_slice(), fits.as_slice()) {
        ([capture], [fit]) => of_one(capture, fit, options)?,
        _ => of_several(&captures, &fits, options)?,
    };
    write_if_asked(options.out.as_ref(), kind::FITTED_MODEL, || model.to_toml())?;
    write_into(options, &model)?;
    write_if_asked(options.report.as_ref(), kind::PAGE, || page)?;
    Ok(Outcome::Done)
}

fn fit_as_asked(loaded: &LoadedCapture, options: &FitOptions) -> anyhow::Result<Fit> {
    let usual = analysis::fit_options(loaded);
    let characteristic = options.characteristic || usual.characteristic;
    let preparation = options.preparation.into();
    Ok(analysis::fit_with(loaded, &identification::FitOptions { characteristic, preparation, ..usual })?)
}

/// Tells the fit of one capture; gives the model, and the page if it was asked for.
fn of_one(capture: &LoadedCapture, fit: &Fit, options: &FitOptions) -> anyhow::Result<(Model, String)> {
    if !is_output_json() {
        show_fit(capture.truth.as_ref(), fit);
    }
    let (page, figures) = options.report.as_ref().map(|_| analysis::fit_page(capture, fit)).unwrap_or_default();
    write_numbers(options.json.as_deref(), capture, fit, figures)?;
    Ok((fit.model(&analysis::title(capture)), page))
}

/// Tells what several captures have in common; gives the model, and the page if it was asked for.
fn of_several(captures: &[LoadedCapture], fits: &[Fit], options: &FitOptions) -> anyhow::Result<(Model, String)> {
    let average = identification::average(fits).context("there is no capture to fit")?;
    let each: Vec<&LoadedCapture> = captures.iter().collect();
    let truth = common_truth(&each);
    if !is_output_json() {
        show_fit(truth, &average.fit);
        average.agreement.map(agreement_line).into_iter().for_each(say);
        say("");
        say(repeatability_table(&average));
    }
    write_json_on(average.fit.axis, options.json.as_deref(), &AverageResult::of(&average, &each, fits))?;
    let page = options.report.as_ref().map(|_| {
        let captures = captures.iter().map(analysis::facts).collect();
        let page = report::average_page(&AveragePage { average: &average, fits, captures, truth });
        average.fit.axis.words(&page).into_owned()
    });
    Ok((average.model(&titles(&each)), page.unwrap_or_default()))
}

/// Writes the model into a joint of a MuJoCo file, if that was asked for.
fn write_into(options: &FitOptions, model: &Model) -> anyhow::Result<()> {
    let Some(path) = &options.into else { return Ok(()) };
    let file = foreign_files::read_text(path).with_context(|| format!("{} cannot be read", path.display()))?;
    let changed = simulators::into_mjcf(&file, options.joint.as_deref(), model)
        .with_context(|| format!("the fitted parameters cannot be written into {}", path.display()))?;
    write(path, Replace::Anything, &changed)?;
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

/// Prints the fit for people, beside the true values where they are known.
pub fn show_fit(truth: Option<&Model>, fit: &Fit) {
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
