//! Captures as commands load them.

use std::path::Path;

use dynamics::{Axis, Model, ModelError, knobs};
use loaded_capture::LoadedCapture;

use crate::command_line::ColumnOptions;
use crate::outcome::remark;

/// The same of a capture or of a file of somebody's tester.
///
/// # Errors
/// One sentence on what is wrong with a file or with the columns that were asked for.
pub fn load_measured(path: &Path, columns: &ColumnOptions) -> anyhow::Result<LoadedCapture> {
    Ok(told(LoadedCapture::load_measured(path, columns.choice()?.as_ref())?))
}

/// The same of a capture whose columns may have been named.
///
/// # Errors
/// One sentence on what is wrong with a file or with the columns that were asked for.
pub fn load_chosen(path: &Path, columns: &ColumnOptions) -> anyhow::Result<LoadedCapture> {
    Ok(told(LoadedCapture::load_chosen(path, columns.choice()?.as_ref())?))
}

/// Loads a capture, and tells where its calibration came from if that was another file.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn load(path: &Path) -> anyhow::Result<LoadedCapture> {
    Ok(told(LoadedCapture::load(path)?))
}

/// The model of a file, or the shipped one that is called so.
///
/// # Errors
/// What is wrong with the file.
pub fn model(path: &Path) -> Result<Model, ModelError> {
    path.to_str().map_or_else(|| Model::load(path), knobs::named)
}

/// The axis of several captures, the turning one of none.
///
/// # Errors
/// Where some turn and others press or slide.
pub fn common_axis(axes: impl IntoIterator<Item = Axis>) -> anyhow::Result<Axis> {
    let mut axes = axes.into_iter();
    let first = axes.next().unwrap_or_default();
    anyhow::ensure!(
        axes.all(|axis| axis == first),
        "some captures are of what turns, others of what is pressed or slid; take them apart"
    );
    Ok(first)
}

fn told(loaded: LoadedCapture) -> LoadedCapture {
    if let Some(file) = &loaded.calibration_file {
        remark(format!("the rig's calibration is that of {}", file.display()));
    }
    loaded
}
