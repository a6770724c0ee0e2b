//! Where the recordings and force curves that others measured lie, for tests.

use std::path::{Path, PathBuf};

/// A folder of that data (`measured`, `force-curves`, `hidden-effects-dev`), or `None` where it is not at hand, which is said.
///
/// `HAPTIC_CAMERA_DATA` may name the folder above; without it that is `shared/data` beside the project.
#[must_use]
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
pub fn folder(name: &str) -> Option<PathBuf> {
    let data = std::env::var_os("HAPTIC_CAMERA_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"), PathBuf::from);
    let folder = data.join(name);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: there is no {}; HAPTIC_CAMERA_DATA may name the folder above", folder.display());
    None
}
