//! Captures as commands load them.

use std::path::Path;

use loaded_capture::LoadedCapture;

use crate::outcome::remark;

/// Loads a capture, and tells where its calibration came from if that was another file.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn load(path: &Path) -> anyhow::Result<LoadedCapture> {
    let loaded = LoadedCapture::load(path)?;
    if let Some(file) = &loaded.calibration_file {
        remark(format!("the rig's calibration is that of {}", file.display()));
    }
    Ok(loaded)
}
