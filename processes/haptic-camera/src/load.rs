//! Captures as commands load them: with a remark where the calibration comes from a file of its own, and where the description was lost.

use std::path::Path;

use dynamics::{Model, ModelError, knobs};
use loaded_capture::LoadedCapture;

use crate::command_line::ColumnOptions;
use crate::outcome::remark;

pub fn load_measured(path: &Path, columns: &ColumnOptions) -> anyhow::Result<LoadedCapture> {
    Ok(with_remark(LoadedCapture::load_measured(path, columns.choice()?.as_ref())?))
}

/// Loads a capture whose columns may have been named.
pub fn load_chosen(path: &Path, columns: &ColumnOptions) -> anyhow::Result<LoadedCapture> {
    Ok(with_remark(LoadedCapture::load_chosen(path, columns.choice()?.as_ref())?))
}

pub fn load(path: &Path) -> anyhow::Result<LoadedCapture> {
    Ok(with_remark(LoadedCapture::load(path)?))
}

/// Loads a model file, or a shipped model by its name.
pub fn model(path: &Path) -> Result<Model, ModelError> {
    path.to_str().map_or_else(|| Model::load(path), knobs::named)
}

/// Whether a name is that of a model: a shipped knob's number or a model file.
pub fn names_model(name: &str) -> bool {
    knobs::is_shipped(name) || Path::new(name).extension().is_some_and(|ending| ending == "toml")
}

fn with_remark(loaded: LoadedCapture) -> LoadedCapture {
    let capture = &loaded.capture;
    // A table has no metadata, and never had a description.
    if capture.description.is_none() && !capture.metadata.is_empty() && !capture.is_rendered() {
        let file = capture.source.display();
        remark(format!("{file} has lost its run.json: if it is of a replay, its torque has the wrong sign"));
    }
    if let Some(file) = &loaded.calibration_file {
        remark(format!("using the rig's calibration from {}", file.display()));
    }
    loaded
}
