//! A diagnosis as a rerun file: torque measured and predicted, the residual's maps, effects beside their rivals.
//!
//! What is drawn is read from the JSON that `haptic-camera diagnose --recording` writes: the diagnosis with its captures'
//! rows.

mod charts;
mod input;
mod layout;
mod series;
mod text;

use std::io::Read as _;
use std::path::Path;

use anyhow::{Context as _, anyhow};
use rerun::{RecordingStreamBuilder, TextDocument};

pub use input::DiagnosisInput;

use crate::entities::SUMMARY;
use crate::recording_file::RecordingFile;

/// Name under which rerun keeps the layout.
const APPLICATION: &str = "haptic-camera-diagnosis";

/// Draws the diagnosis in `json` into a rerun file.
/// An error is one sentence on what is wrong with the JSON, or why the file cannot be written.
pub fn record(json: &Path, out: &Path) -> anyhow::Result<()> {
    let mut text = String::new();
    let read = foreign_files::open(json).and_then(|mut file| file.read_to_string(&mut text));
    read.with_context(|| format!("{} cannot be read", json.display()))?;
    let input: DiagnosisInput = serde_json::from_str(&text).map_err(|error| {
        let why = format!("the diagnosis cannot be read: {error}; write it anew with `haptic-camera diagnose`");
        anyhow!(why).context(format!("{} is no diagnosis", json.display()))
    })?;
    let file = RecordingFile::create(out)?;
    let recording = RecordingStreamBuilder::new(APPLICATION).buffered()?;
    recording.set_sink(Box::new(file.sink()));
    recording.set_log_tick_enabled(false);
    recording.set_log_time_enabled(false);
    layout::send(&recording, &input)?;
    recording.log_static(SUMMARY, &TextDocument::from_markdown(text::markdown(&input)))?;
    for capture in &input.captures {
        series::draw(&recording, capture)?;
    }
    charts::draw(&recording, &input)?;
    recording.flush_blocking().context("the recording could not be finished")?;
    file.finish()
}
