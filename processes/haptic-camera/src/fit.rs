//! `fit`: from a capture to a model.

use std::path::PathBuf;

use analysis::{AverageResult, FitResult, common_truth, titles};
use anyhow::Context as _;
use archive::whole_file::Replace;
use clap::Args;
use dynamics::Model;
use identification::{Fit, MeasuredCurve, PreparationMethod};
use loaded_capture::LoadedCapture;
use report::AveragePage;

use crate::command_line::ColumnOptions;
use crate::fit_tables::{agreement_line, harmonic_table, parameter_table, reasons, repeatability_table};
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::{ResultFiles, kind, show_on, write, write_if_asked};

#[derive(Debug, Args)]
pub struct FitOptions {
    /// The capture: an archive, a CSV or an MDF file; several of the same knob give one model
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    #[command(flatten)]
    pub results: ResultFiles,
    /// Write the fitted model
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
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

pub fn run(options: &FitOptions) -> anyhow::Result<Outcome> {
    let captures = options.captures.iter().map(|path| load::load_measured(path, &options.columns));
    let captures = captures.collect::<anyhow::Result<Vec<_>>>()?;
    load::common_axis(captures.iter().map(|one| one.capture.axis))?;
    let fits = captures.iter().map(|one| fit_as_asked(one, options)).collect::<anyhow::Result<Vec<Fit>>>()?;
    let model = match (captures.as_slice(), fits.as_slice()) {
        ([capture], [fit]) => {
            show_on(fit.axis, lines(capture.truth.as_ref(), fit));
            write_results(&options.results, capture, fit)?;
            fit.model(&analysis::title(capture))
        }
        _ => of_several(&captures, &fits, options)?,
    };
    write_if_asked(&options.out, kind::FITTED_MODEL, || model.to_toml())?;
    write_into(options, &model)?;
    Ok(Outcome::Done)
}

fn fit_as_asked(loaded: &LoadedCapture, options: &FitOptions) -> anyhow::Result<Fit> {
    let usual = analysis::fit_options(loaded);
    let characteristic = options.characteristic || usual.characteristic;
    let preparation = match options.preparation {
        Preparation::Automatic => PreparationMethod::Automatic,
        Preparation::Paper => PreparationMethod::Paper,
        Preparation::CentralDifferences => PreparationMethod::CentralDifferences,
    };
    Ok(analysis::fit_with(loaded, &identification::FitOptions { characteristic, preparation, ..usual })?)
}

/// Tells what several captures have in common, and gives the model.
fn of_several(captures: &[LoadedCapture], fits: &[Fit], options: &FitOptions) -> anyhow::Result<Model> {
    let average = identification::average(fits).context("there is no capture to fit")?;
    let each: Vec<&LoadedCapture> = captures.iter().collect();
    let truth = common_truth(&each);
    let mut lines = lines(truth, &average.fit);
    lines.extend(average.agreement.map(agreement_line));
    lines.extend([String::new(), repeatability_table(&average).to_string()]);
    options.results.tell(average.fit.axis, lines, &AverageResult::of(&average, &each, fits), || {
        let captures = captures.iter().map(analysis::facts).collect();
        report::average_page(&AveragePage { average: &average, fits, captures, truth })
    })?;
    Ok(average.model(&titles(&each)))
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

/// Writes every number of a fit as JSON and the page, what of them was asked for.
pub fn write_results(results: &ResultFiles, loaded: &LoadedCapture, fit: &Fit) -> anyhow::Result<()> {
    let result = |figures| FitResult::of(loaded, fit, figures);
    results.write(fit.axis, || analysis::fit_page(loaded, fit), result)
}

/// Fits a capture with all that is known of its rig.
pub fn fit_capture(loaded: &LoadedCapture) -> anyhow::Result<Fit> {
    Ok(analysis::fit(loaded, PreparationMethod::default())?)
}

/// The fit for people, beside the true values where they are known.
pub fn lines(truth: Option<&Model>, fit: &Fit) -> Vec<String> {
    let decimals = decimals(fit.mean_ci95_mnm);
    let mut lines = vec![parameter_table(fit, truth).to_string()];
    lines.push(format!(
        "residual {:.decimals$} mNm RMS, {:.2} % of the torque; mean 95 % interval ±{:.decimals$} mNm",
        fit.residual_rms_mnm, fit.relative_error_percent, fit.mean_ci95_mnm
    ));
    lines.extend(fit.characteristics.iter().map(characteristic_line));
    lines.extend(harmonic_table(fit).iter().flat_map(|table| [String::new(), table.to_string()]));
    lines.extend(reasons(fit).iter().chain(&fit.notes).map(|line| format!("- {line}")));
    lines
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
