//! The parts that a recorder leaves until their archive is ended, and where they may lie.

use std::path::{Path, PathBuf};

use shared_types::rig::open_private_dir;

use crate::error::ArchiveError;
use crate::{merge, own_file};

/// Most parts of one archive in one folder.
pub const MOST: usize = 1_000;

/// The name of part `number` of an archive, in `directory`.
#[must_use]
pub fn path(archive: &Path, directory: &Path, number: usize) -> PathBuf {
    let name = archive.file_name().map_or_else(|| "capture.mcap".into(), |name| name.to_string_lossy());
    directory.join(format!("{name}.part-{number:03}"))
}

/// A file that is named like a part.
#[derive(Debug)]
pub struct Part {
    /// The file.
    pub path: PathBuf,
    /// The run that it says it belongs to, or why it was left alone.
    pub run_id: Result<Option<u64>, ArchiveError>,
}

impl Part {
    /// Whether nothing was ever written to it, by a recorder that was killed at once.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        own_file::open(&self.path).and_then(|file| file.metadata()).is_ok_and(|found| found.len() == 0)
    }
}

/// The parts of an archive that lie in `directory`, oldest first. What the user did not make himself is not opened.
#[must_use]
pub fn find(archive: &Path, directory: &Path) -> Vec<Part> {
    let paths = (0..MOST).map(|number| path(archive, directory, number));
    let there = paths.filter(|path| path.symlink_metadata().is_ok());
    there.map(|path| Part { run_id: merge::run_id(&path), path }).collect()
}

/// Where a run's parts and archive go when the folder that was asked for fails: a folder in the temporary directory that only its
/// user may enter.
#[must_use]
pub fn fallback_dir(run_id: u64) -> PathBuf {
    std::env::temp_dir().join(format!("{}{run_id:016x}", fallback_prefix()))
}

/// Makes [`fallback_dir`], unless it is there.
///
/// # Errors
/// The system's, and where another user has the name.
pub fn create_fallback_dir(run_id: u64) -> std::io::Result<PathBuf> {
    use std::os::unix::fs::DirBuilderExt as _;
    let directory = fallback_dir(run_id);
    match std::fs::DirBuilder::new().mode(0o700).create(&directory) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => return Err(error),
        _ => open_private_dir(&directory)?,
    };
    Ok(directory)
}

/// The fallback folders of all the user's runs.
#[must_use]
pub fn fallback_dirs() -> Vec<PathBuf> {
    let prefix = fallback_prefix();
    let entries = std::fs::read_dir(std::env::temp_dir()).into_iter().flatten().flatten();
    let named = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    named.map(|entry| entry.path()).filter(|path| open_private_dir(path).is_ok()).collect()
}

fn fallback_prefix() -> String {
    format!("haptic-camera-{}-", nix::unistd::geteuid())
}
