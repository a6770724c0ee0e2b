//! `diagnose`: what a model lacks.

use std::path::{Path, PathBuf};

use analysis::{DiagnosisResult, diagnosed_model, refuse_drawn};
use clap::Args;
use dynamics::{Axis, Model};
use identification::diagnosis::Progress;
use indicatif::ProgressBar;
use report::DiagnosisPage;

use crate::command_line::ColumnOptions;
use crate::diagnosis_text;
use crate::load;
use crate::outcome::{Outcome, show};
use crate::outputs::{kind, write, write_if_asked, write_json_on};
use crate::recording;
use crate::terminal;

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseOptions {
    /// The capture that models are fitted to: an archive, a CSV or an MDF file
    #[arg(value_name = "CAPTURE")]
    pub train: PathBuf,
    /// A held-out capture of the same knob with another motion; without one, sections of the first are held out
    #[arg(long, value_name = "CAPTURE")]
    pub heldout: Option<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// The model to start from [default: inertia, friction and detents, fitted]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the diagnosis as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the model with the added effects
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write a rerun file: measured and predicted torque, maps of the residual, each effect with its rivals
    #[arg(long, value_name = "FILE.rrd")]
    pub recording: Option<PathBuf>,
}

/// Diagnoses a capture and writes what was asked for.
///
/// # Errors
/// Why there can be no meaningful verdict, in one sentence, or what is wrong with a file.
pub fn run(options: &DiagnoseOptions) -> anyhow::Result<Outcome> {
    let load = |path: &Path| load::load_chosen(path, &options.columns);
    let train = load(&options.train)?;
    let heldout = options.heldout.as_deref().map(load).transpose()?;
    let axis = train.capture.axis;
    let model = options.model.as_deref().map(starting_model).transpose()?;
    let bar = progress_bar();
    let progress = |progress: Progress| show_progress(&bar, progress);
    let found = analysis::diagnose(&train, heldout.as_ref(), model, Some(&progress));
    bar.finish_and_clear();
    let found = found?;
    show(diagnosis_text::lines(&found).iter().map(|line| axis.words(line)));
    write_if_asked(options.out.as_ref(), kind::DIAGNOSED_MODEL, || diagnosed_model(&found, &train).to_toml())?;
    let page =
        DiagnosisPage { found: &found, train: analysis::facts(&train), heldout: heldout.as_ref().map(analysis::facts) };
    tell(axis, &page, options.json.as_deref(), options.report.as_deref())?;
    if let Some(path) = &options.recording {
        recording::write(path, &found, &analysis::title(&train), heldout.as_ref().map(analysis::title).as_deref())?;
    }
    Ok(Outcome::Done)
}

/// Writes a diagnosis as JSON and as a page, what of them was asked for.
///
/// # Errors
/// When a file cannot be written.
pub fn tell(axis: Axis, page: &DiagnosisPage<'_>, json: Option<&Path>, report: Option<&Path>) -> anyhow::Result<()> {
    let made = report.map(|path| (path, report::diagnosis_page_with_numbers(page)));
    let figures = made.as_ref().map(|(_, (_, figures))| figures.clone()).unwrap_or_default();
    write_json_on(axis, json, &DiagnosisResult::of(page, figures))?;
    made.map_or(Ok(()), |(path, (html, _))| write(path, kind::PAGE, &axis.words(&html)))
}

/// The model to start from.
fn starting_model(path: &Path) -> anyhow::Result<Model> {
    let model = load::model(path)?;
    refuse_drawn(&model, &path.display().to_string())?;
    Ok(model)
}

/// A bar for [`show_progress`].
pub fn progress_bar() -> ProgressBar {
    terminal::bar(1, "{bar:24} {pos}/{len} {msg}")
}

/// Shows how far a diagnosis is.
pub fn show_progress(bar: &ProgressBar, progress: Progress) {
    match progress {
        Progress::Tried { effect, done, of } => {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
            bar.set_message(effect);
        }
        Progress::Added { effect, heldout_over_floor } => {
            bar.println(format!("added {effect}: residual {heldout_over_floor:.2} times the noise"));
        }
    }
}
