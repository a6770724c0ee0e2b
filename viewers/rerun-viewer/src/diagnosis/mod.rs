//! A diagnosis as a rerun file: torque measured and predicted, the residual's maps, effects beside their rivals.

mod charts;
mod layout;
mod series;
mod text;

use std::io::Read as _;
use std::path::Path;

use anyhow::{Context as _, anyhow};
use identification::diagnosis::{Diagnosis, Rival, Row, Step};
use rerun::{RecordingStreamBuilder, TextDocument};
use serde::Deserialize;

use crate::entities::SUMMARY;
use crate::recording_file::RecordingFile;
use crate::screen::sent_to;

/// Name under which rerun keeps the layout.
const APPLICATION: &str = "haptic-camera-diagnosis";

/// What `haptic-camera diagnose --recording` hands over.
#[derive(Deserialize)]
#[serde(bound(deserialize = "'de: 'static"))]
struct Input {
    diagnosis: Diagnosis,
    /// Training first, then held-out.
    captures: Vec<CaptureRows>,
}

/// The rows of a capture in the order of time.
#[derive(Deserialize)]
struct CaptureRows {
    /// `training` or `heldout`.
    role: String,
    source: String,
    rows: Vec<Row>,
}

/// Draws the diagnosis in `json` into a rerun file.
/// An error is one sentence on what is wrong with the JSON, or why the file cannot be written.
pub fn record(json: &Path, out: &Path) -> anyhow::Result<()> {
    let mut text = String::new();
    let read = foreign_files::open(json).and_then(|mut file| file.read_to_string(&mut text));
    read.with_context(|| format!("{} cannot be read", json.display()))?;
    // The names in a diagnosis live as long as the program, which ends with the file.
    let input: Input = serde_json::from_str(text.leak()).map_err(|error| {
        let why = format!("the diagnosis cannot be read: {error}; write it anew with `haptic-camera diagnose`");
        anyhow!(why).context(format!("{} is no diagnosis", json.display()))
    })?;
    let file = RecordingFile::create(out)?;
    let recording = sent_to(file.sink(), RecordingStreamBuilder::new(APPLICATION))?;
    recording.set_log_tick_enabled(false);
    recording.set_log_time_enabled(false);
    layout::send(&recording, &input)?;
    recording.log_static(SUMMARY, &TextDocument::from_markdown(text::markdown(&input)))?;
    for capture in &input.captures {
        series::draw(&recording, capture)?;
    }
    charts::draw(&recording, &input.diagnosis)?;
    recording.flush_blocking().context("the recording could not be finished")?;
    file.finish()
}

/// The effect of a step, then its rivals.
fn contenders(step: &Step) -> Vec<Rival> {
    let Step { effect, heldout_rms_after, evidence, .. } = *step;
    let chosen = Rival { effect, heldout_rms_after, evidence, probability: f64::NAN, disqualified: None };
    std::iter::once(chosen).chain(step.rivals.iter().cloned()).collect()
}
