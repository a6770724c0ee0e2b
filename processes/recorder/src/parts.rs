//! The parts of this run that lie on the disk.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use archive::parts;

/// The first name for a part that is still free.
pub(crate) fn next_free(out: &Path, directory: &Path) -> anyhow::Result<PathBuf> {
    (0..parts::MOST)
        .map(|number| parts::path(out, directory, number))
        .find(|path| path.symlink_metadata().is_err())
        .with_context(|| format!("{} has {} parts already; move them away", out.display(), parts::MOST))
}

/// The parts of this run that lie in `directory`, oldest first; a file that is not known to be a part of it is left alone.
pub(crate) fn of_run(out: &Path, directory: &Path, run_id: u64) -> Vec<PathBuf> {
    let is_ours = |part: &parts::Part| match part.run_id {
        Ok(Some(found)) => found == run_id,
        // It was left by a recorder that was killed at once. It holds nothing, and may be removed.
        Ok(None) => part.is_empty(),
        Err(_) => false,
    };
    let (ours, others): (Vec<_>, Vec<_>) = parts::find(out, directory).into_iter().partition(is_ours);
    if let [first, more @ ..] = others.as_slice() {
        let why = first.run_id.as_ref().err().map_or_else(|| first.path.display().to_string(), ToString::to_string);
        tracing::warn!("not a part of this run, skipped: {why}, and {} more files of such names", more.len());
    }
    ours.into_iter().map(|part| part.path).collect()
}

/// Removes parts whose content is safe elsewhere.
pub(crate) fn remove(parts: &[PathBuf]) {
    for part in parts {
        if let Err(error) = std::fs::remove_file(part) {
            tracing::warn!("{} was merged but cannot be removed: {error}", part.display());
        }
    }
}
