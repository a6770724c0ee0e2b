//! `fit`: from a capture to a model.

use std::path::PathBuf;

use analysis::{AverageResult, FitResult, common_truth, titles};
use anyhow::Context as _;
use archive::whole_file::Replace;
use clap::Args;
use comfy_table::Table;
use dynamics::Model;
use identification::statistics::{half_width, range};
use identification::{Agreement, Average, Fit, MeasuredCurve, Parameter, PreparationMethod};
use loaded_capture::LoadedCapture;
use report::{AveragePage, true_value};
use simulator_formats::IntoMjcfError;

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::{ResultFiles, kind, show_on, write, write_if_asked};
use crate::load;
use crate::outcome::{say, with_options};
use crate::terminal::{by_reason, digits, interval, table};

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
    pub preparation: PreparationMethod,
}

pub fn run(options: &FitOptions) -> anyhow::Result<()> {
    let captures = options.captures.iter().map(|path| load::load_measured(path, &options.columns));
    let captures = captures.collect::<anyhow::Result<Vec<_>>>()?;
    analysis::common_axis(captures.iter().map(|one| one.capture.axis))?;
    let fit = |loaded: &LoadedCapture| {
        let usual = analysis::fit_options(loaded);
        let characteristic = options.characteristic || usual.characteristic;
        let preparation = options.preparation;
        analysis::fit_with(loaded, &identification::FitOptions { characteristic, preparation, ..usual })
    };
    let fits = captures.iter().map(fit).collect::<Result<Vec<Fit>, _>>()?;
    let model = match (captures.as_slice(), fits.as_slice()) {
        ([capture], [fit]) => {
            show_on(fit.axis, lines(capture.truth.as_ref(), fit));
            write_results(&options.results, capture, fit)?;
            fit.model(&capture.title())
        }
        _ => of_several(&captures, &fits, options)?,
    };
    write_if_asked(&options.out, kind::FITTED_MODEL, || model.to_toml())?;
    write_into(options, &model)
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

fn write_into(options: &FitOptions, model: &Model) -> anyhow::Result<()> {
    let Some(path) = &options.into else { return Ok(()) };
    let file = foreign_files::read_text(path).with_context(|| format!("{} cannot be read", path.display()))?;
    let changed = simulator_formats::into_mjcf(&file, options.joint.as_deref(), model)
        .map_err(|error| match error {
            IntoMjcfError::Joint { .. } => with_options(error, "--joint"),
            _ => error.into(),
        })
        .with_context(|| format!("the fitted parameters cannot be written into {}", path.display()))?;
    write(path, Replace::Anything, &changed)?;
    say(format!(
        "{}: armature, damping, frictionloss and detents; the armature is the whole inertia, so give the body almost \
         none",
        path.display()
    ));
    Ok(())
}

/// Writes every number of a fit as JSON and as the page, each if it was asked for.
pub fn write_results(results: &ResultFiles, loaded: &LoadedCapture, fit: &Fit) -> anyhow::Result<()> {
    let result = |figures| FitResult::of(loaded, fit, figures);
    results.write(fit.axis, || analysis::fit_page(loaded, fit), result)
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
    let reasons = fit.parameters.0.iter().filter_map(|known| Some((known.name, known.reason.as_deref()?)));
    lines.extend(by_reason(reasons).iter().chain(&fit.notes).map(|line| format!("- {line}")));
    lines
}

/// Three decimals, or as many as show a small number.
fn decimals(value: f64) -> usize {
    if value > 0.0 && value < 0.005 { 5 } else { 3 }
}

/// A measured curve in a line; its points are in the JSON and in the model file.
fn characteristic_line(MeasuredCurve { effect, points }: &MeasuredCurve) -> String {
    let [least, most] = range(points.iter().map(|point| point.torque_mnm));
    let halves = points.iter().filter_map(|point| point.ci95).map(|[low, high]| 0.5 * (high - low));
    let widest = halves.fold(0.0, f64::max);
    let (count, decimals) = (points.len(), decimals(widest));
    format!(
        "{effect}: {count} points, {least:.decimals$} to {most:.decimals$} mNm, each known to ±{widest:.decimals$} mNm or better"
    )
}

fn parameter_table(fit: &Fit, truth: Option<&Model>) -> Table {
    let mut header = vec!["parameter", "fitted", "95 % interval", "unit"];
    if truth.is_some() {
        header.extend(["true", ""]);
    }
    let row = |parameter: &Parameter| {
        let digits = digits(match (parameter.ci95, parameter.value) {
            (Some([low, high]), _) if high > low => high - low,
            (_, value) => 1e-3 * value.unwrap_or(0.0).abs(),
        });
        let (value, interval) = match parameter.value {
            Some(value) => (format!("{value:.digits$}"), interval(parameter.ci95, digits)),
            None => ("-".to_owned(), "not identifiable".to_owned()),
        };
        let mut row =
            vec![parameter.name.to_owned(), value, interval, dynamics::printed_unit(parameter.unit).to_owned()];
        row.extend(truth.into_iter().flat_map(|model| truth_cells(parameter, model, digits)));
        row
    };
    table(header, [1, 2, 4], fit.parameters.0.iter().map(row))
}

fn truth_cells(parameter: &Parameter, model: &Model, digits: usize) -> [String; 2] {
    let Some(value) = true_value(Some(model), parameter.name, None) else { return ["none".to_owned(), String::new()] };
    let inside = report::holds(parameter.ci95, value).map_or("", |holds| if holds { "in" } else { "out" });
    [format!("{value:.digits$}"), inside.to_owned()]
}

/// The sinusoids, strongest first; `None` if there are none.
fn harmonic_table(fit: &Fit) -> Option<Table> {
    let harmonics = &fit.detent_harmonics;
    let first = harmonics.first()?;
    let whole_model = first.relative_error_percent.is_some();
    let share = if whole_model { "relative error with it %" } else { "of the residual %" };
    // Where every harmonic is a whole number per turn, it is written as one.
    let digits = if harmonics.iter().all(|one| one.per_turn.fract() == 0.0) { 0 } else { 3 };
    let with_interval = |value: f64, ci95: Option<[f64; 2]>| {
        ci95.map_or_else(|| format!("{value:.3}"), |ci95| format!("{value:.3} ± {:.3}", half_width(value, ci95)))
    };
    let rows = harmonics.iter().map(|harmonic| {
        [
            format!("{:.digits$}", harmonic.per_turn),
            harmonic.order.map_or_else(String::new, |order| format!("{order}×")),
            with_interval(harmonic.amplitude_mnm, harmonic.amplitude_ci95_mnm),
            with_interval(harmonic.phase_rad, harmonic.phase_ci95_rad),
            format!("{:.2}", harmonic.relative_error_percent.unwrap_or(harmonic.explains_percent)),
        ]
    });
    Some(table(["per turn", "of the detent", "amplitude mNm", "phase rad", share], 0..5, rows))
}

/// Most captures whose values stand side by side; for more captures, only the differences are shown.
const SIDE_BY_SIDE: usize = 3;

fn repeatability_table(average: &Average) -> Table {
    let mut header = vec!["parameter".to_owned()];
    let shown = if average.captures <= SIDE_BY_SIDE { average.captures } else { 0 };
    header.extend((1..=shown).map(|number| format!("capture {number}")));
    header.extend(["difference", "allowed", "ratio", "unit"].map(str::to_owned));
    let row = |parameter: &Parameter| {
        let record = average.repeatability.get(parameter.name)?;
        let digits = digits(record.difference_ci95);
        let value = |value: &Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"));
        let mut row = vec![parameter.name.to_owned()];
        row.extend(record.values.iter().take(shown).map(value));
        row.extend([format!("{:.digits$}", record.difference), format!("±{:.digits$}", record.difference_ci95)]);
        row.extend([format!("{:.2}", record.ratio), record.unit.to_owned()]);
        Some(row)
    };
    table(header, 1..shown + 4, average.fit.parameters.0.iter().filter_map(row))
}

pub fn agreement_line(agreement: Agreement) -> String {
    let words = if agreement.agrees() { "agree within" } else { "differ by more than" };
    format!(
        "the captures {words} their intervals: chi-squared {:.1} over {} degrees of freedom (p = {:.2e}), Birge ratio {:.2}",
        agreement.chi_squared, agreement.degrees_of_freedom, agreement.probability, agreement.birge_ratio
    )
}
