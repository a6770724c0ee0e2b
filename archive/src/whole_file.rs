//! Files that are either there whole or not at all.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crate::error::ArchiveError;

/// Writes a file under a temporary name beside `path`, then puts it in its place.
///
/// The content is on the disk before the name is: a crash leaves the old file or the new one.
///
/// # Errors
/// What `write` reports, or [`ArchiveError::File`] when the operating system refuses. The
/// temporary file is removed then.
pub fn write_whole<Written>(
    path: &Path,
    write: impl FnOnce(BufWriter<File>) -> Result<Written, ArchiveError>,
) -> Result<Written, ArchiveError> {
    let temporary = beside(path, ".incomplete");
    let written = create_and_sync(path, &temporary, write).and_then(|written| {
        put_in_place(&temporary, path)?;
        Ok(written)
    });
    if written.is_err() {
        // It may never have been made; the error that matters is the one above.
        let _ = std::fs::remove_file(&temporary);
    }
    written
}

fn create_and_sync<Written>(
    path: &Path,
    temporary: &Path,
    write: impl FnOnce(BufWriter<File>) -> Result<Written, ArchiveError>,
) -> Result<Written, ArchiveError> {
    let refused = |error| ArchiveError::File { path: path.to_owned(), error };
    let file = File::create(temporary).map_err(refused)?;
    let handle = file.try_clone().map_err(refused)?;
    let written = write(BufWriter::with_capacity(1 << 20, file))?;
    handle.sync_all().map_err(refused)?;
    Ok(written)
}

/// Renames a finished file and makes the new name durable.
///
/// # Errors
/// [`ArchiveError::File`] when the operating system refuses.
pub fn put_in_place(from: &Path, to: &Path) -> Result<(), ArchiveError> {
    std::fs::rename(from, to).map_err(|error| ArchiveError::file(to, error))?;
    sync_directory(to)
}

/// Makes the entry of `path` in its directory durable.
///
/// # Errors
/// [`ArchiveError::File`] when the operating system refuses.
pub fn sync_directory(path: &Path) -> Result<(), ArchiveError> {
    let parent = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    File::open(parent).and_then(|directory| directory.sync_all()).map_err(|error| ArchiveError::file(parent, error))
}

/// `path` with `ending` appended to its file name.
#[must_use]
pub fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}
