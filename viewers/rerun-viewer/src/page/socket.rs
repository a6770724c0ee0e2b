//! The socket at which the page is served to the guard, in the rig's folder, which belongs to the user alone.

use std::path::{Path, PathBuf};

use shared_types::rig;

const PREFIX: &str = "live-view-";
const SUFFIX: &str = ".socket";

/// Path of this process's socket, where nothing is yet. Those that killed processes left are removed.
///
/// # Errors
/// When there is no folder.
pub(super) fn place() -> std::io::Result<PathBuf> {
    let folder = rig::create_runtime_dir()?;
    for entry in std::fs::read_dir(&folder)?.flatten() {
        if owner(&entry.path()).is_some_and(|process_id| !rig::process_exists(process_id)) {
            // Another viewer may have been faster.
            let _ = std::fs::remove_file(entry.path());
        }
    }
    remove();
    Ok(of_this_process())
}

/// Removes this process's socket, if it has one, at its end.
pub fn remove() {
    let _ = std::fs::remove_file(of_this_process());
}

fn of_this_process() -> PathBuf {
    rig::runtime_dir().join(format!("{PREFIX}{}{SUFFIX}", std::process::id()))
}

/// The process whose socket this is.
fn owner(path: &Path) -> Option<u32> {
    path.file_name()?.to_str()?.strip_prefix(PREFIX)?.strip_suffix(SUFFIX)?.parse().ok()
}
