//! Captures as commands load them.

use std::path::Path;

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

fn told(loaded: LoadedCapture) -> LoadedCapture {
    if let Some(file) = &loaded.calibration_file {
        remark(format!("the rig's calibration is that of {}", file.display()));
    }
    loaded
}
