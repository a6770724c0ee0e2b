//! The parts that lie on the disk, and the archive that they become.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::whole_file::beside;

/// Most parts of one archive.
const MAX_PARTS: usize = 1_000;

/// The name of part `number` of the archive `out`, in `directory`.
fn part_path(out: &Path, directory: &Path, number: usize) -> PathBuf {
    let name = out.file_name().map_or_else(|| Path::new("capture.mcap"), Path::new);
    directory.join(beside(name, &format!(".part-{number:03}")))
}

/// The directory of `path`.
pub(crate) fn directory_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// The first name for a part that is still free.
pub(crate) fn next_free(out: &Path, directory: &Path) -> anyhow::Result<PathBuf> {
    (0..MAX_PARTS)
        .map(|number| part_path(out, directory, number))
        .find(|path| path.symlink_metadata().is_err())
        .with_context(|| format!("{} has {MAX_PARTS} parts already; move them away", out.display()))
}

/// The parts of this run that lie in `directory`, oldest first; parts of other runs are left alone.
pub(crate) fn of_run(out: &Path, directory: &Path, run_id: u64) -> Vec<PathBuf> {
    (0..MAX_PARTS)
        .map(|number| part_path(out, directory, number))
        .filter(|path| path.is_file())
        .filter(|path| match archive::run_id(path) {
            Ok(found) => {
                let ours = found.is_none_or(|found| found == run_id);
                if !ours {
                    tracing::warn!("{} is left over from another run and stays as it is", path.display());
                }
                ours
            }
            Err(error) => {
                tracing::warn!("a part is left out: {error}");
                false
            }
        })
        .collect()
}

/// Removes parts whose content is safe elsewhere.
pub(crate) fn remove(parts: &[PathBuf]) {
    for part in parts {
        if let Err(error) = std::fs::remove_file(part) {
            tracing::warn!("{} was merged but cannot be removed: {error}", part.display());
        }
    }
}
