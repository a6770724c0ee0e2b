//! `diagnose`: what a model lacks.

pub(crate) mod text;

use std::path::{Path, PathBuf};
use std::process::Stdio;

use analysis::{DiagnosisResult, diagnosed_model, refuse_drawn};
use anyhow::Context as _;
use clap::Args;
use identification::diagnosis::{Diagnosis, Progress};
use loaded_capture::LoadedCapture;
use report::DiagnosisPage;
use serde_json::json;

use crate::command_line::ColumnOptions;
use crate::command_line::outputs::{ResultFiles, kind, show_on, write_if_asked};
use crate::supervision::bare_program;
use crate::{load, terminal};

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

pub fn run(options: &DiagnoseOptions) -> anyhow::Result<()> {
    let load = |path: &Path| load::load_chosen(path, &options.columns);
    let train = load(&options.train)?;
    let heldout = options.heldout.as_deref().map(load).transpose()?;
    let model = options.model.as_deref().map(load::model).transpose()?;
    if let Some((model, path)) = model.as_ref().zip(options.model.as_ref()) {
        refuse_drawn(model, &path.display().to_string())?;
    }
    let found = with_progress(|progress| Ok(analysis::diagnose(&train, heldout.as_ref(), model, Some(progress))?))?;
    show_on(train.capture.axis, text::lines(&found));
    let (trained, _) = found.in_their_roles(&train, heldout.as_ref());
    write_if_asked(&options.out, kind::DIAGNOSED_MODEL, || diagnosed_model(&found, &[trained]).to_toml())?;
    write_results(&options.results, &options.recording, &found, &train, heldout.as_ref())
}

/// Writes a diagnosis of a training and a held-out capture as JSON, page and rerun file, each if it was asked for.
///
/// The rerun file is written by running the viewer's program, since this program does not contain rerun. Without a held-out capture,
/// the held-out rows are stretches of the training capture.
pub fn write_results(
    results: &ResultFiles,
    recording: &Option<PathBuf>,
    found: &Diagnosis,
    train: &LoadedCapture,
    heldout: Option<&LoadedCapture>,
) -> anyhow::Result<()> {
    let (train, heldout) = found.in_their_roles(train, heldout);
    let page = DiagnosisPage { found, train: analysis::facts(train), heldout: heldout.map(analysis::facts) };
    let result = |figures| DiagnosisResult::of(&page, figures);
    results.write(train.capture.axis, || report::diagnosis_page_with_numbers(&page), result)?;
    let Some(path) = recording else { return Ok(()) };
    let [of_train, of_heldout] = &found.rows;
    let captures = [("training", train, of_train), ("heldout", heldout.unwrap_or(train), of_heldout)];
    let captures = captures.map(|(role, loaded, rows)| json!({ "role": role, "source": loaded.title(), "rows": rows }));
    let recording = json!({ "diagnosis": found, "captures": captures });
    let folder = tempfile::tempdir().context("the recording's rows cannot be stored")?;
    let json = folder.path().join("diagnosis.json");
    std::fs::write(&json, serde_json::to_vec(&recording)?).context("the recording's rows cannot be written")?;
    let ended = bare_program("rerun-viewer")?
        .args([Path::new("diagnosis"), &json, Path::new("--out"), path])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .context("the viewer's program cannot be started; build the whole workspace")?;
    anyhow::ensure!(ended.success(), "{} is not written; see the viewer's error above", path.display());
    Ok(())
}

/// Makes a diagnosis while a bar shows how far it is.
pub fn with_progress(
    diagnose: impl FnOnce(&(dyn Fn(Progress) + Sync)) -> anyhow::Result<Diagnosis>,
) -> anyhow::Result<Diagnosis> {
    let bar = terminal::bar(Some(1), "{bar:24} {pos}/{len} {msg}");
    diagnose(&|progress| match progress {
        Progress::Tried { effect, done, of } => {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
            bar.set_message(effect);
        }
        Progress::Added { effect, heldout_over_floor } => {
            bar.println(format!("added {effect}: residual {heldout_over_floor:.2} times the noise"));
        }
    })
}
