//! `diagnose`: what a model lacks.

use std::path::{Path, PathBuf};

use analysis::{DiagnosisResult, diagnosed_model, refuse_drawn};
use clap::Args;
use dynamics::{Axis, Model};
use identification::diagnosis::{Diagnosis, Progress};
use report::DiagnosisPage;

use crate::command_line::ColumnOptions;
use crate::diagnosis_text;
use crate::load;
use crate::outcome::Outcome;
use crate::outputs::{ResultFiles, kind, show_on, write_if_asked};
use crate::recording;
use crate::terminal;

#[derive(Debug, Args)]
pub struct DiagnoseOptions {
    /// The capture that models are fitted to: an archive, a CSV or an MDF file
    #[arg(value_name = "CAPTURE")]
    pub train: PathBuf,
    /// A held-out capture of the same knob with another motion; without one, sections of the first are held out
    #[arg(long, value_name = "CAPTURE")]
    pub heldout: Option<PathBuf>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// The model to start from [default: inertia, friction and detents, fitted]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    #[command(flatten)]
    pub results: ResultFiles,
    /// Write the model with the added effects
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
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
    let found = with_progress(|progress| Ok(analysis::diagnose(&train, heldout.as_ref(), model, Some(progress))?))?;
    show_on(axis, diagnosis_text::lines(&found));
    write_if_asked(&options.out, kind::DIAGNOSED_MODEL, || diagnosed_model(&found, &train).to_toml())?;
    let page =
        DiagnosisPage { found: &found, train: analysis::facts(&train), heldout: heldout.as_ref().map(analysis::facts) };
    write_results(&options.results, axis, &page)?;
    if let Some(path) = &options.recording {
        recording::write(path, &found, &analysis::title(&train), heldout.as_ref().map(analysis::title).as_deref())?;
    }
    Ok(Outcome::Done)
}

/// Writes a diagnosis as JSON and as a page, what of them was asked for.
pub fn write_results(results: &ResultFiles, axis: Axis, page: &DiagnosisPage<'_>) -> anyhow::Result<()> {
    let result = |figures| DiagnosisResult::of(page, figures);
    results.write(axis, || report::diagnosis_page_with_numbers(page), result)
}

fn starting_model(path: &Path) -> anyhow::Result<Model> {
    let model = load::model(path)?;
    refuse_drawn(&model, &path.display().to_string())?;
    Ok(model)
}

/// Makes a diagnosis while a bar shows how far it is.
pub fn with_progress(
    diagnose: impl FnOnce(&(dyn Fn(Progress) + Sync)) -> anyhow::Result<Diagnosis>,
) -> anyhow::Result<Diagnosis> {
    let bar = terminal::bar(Some(1), "{bar:24} {pos}/{len} {msg}");
    let found = diagnose(&|progress| match progress {
        Progress::Tried { effect, done, of } => {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
            bar.set_message(effect);
        }
        Progress::Added { effect, heldout_over_floor } => {
            bar.println(format!("added {effect}: residual {heldout_over_floor:.2} times the noise"));
        }
    });
    bar.finish_and_clear();
    found
}
