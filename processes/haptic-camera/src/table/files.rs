//! The captures of folders, and of the folders in them.

use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use anyhow::Context as _;

/// A file as it was seen; one that was changed since is another.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Seen {
    pub(super) path: PathBuf,
    pub(super) bytes: u64,
    pub(super) written_ns: u128,
}

/// All `.mcap` and `.csv` files, by their paths, each once.
pub(super) fn captures(folders: &[PathBuf]) -> anyhow::Result<Vec<Seen>> {
    let mut files = Vec::new();
    for folder in folders {
        add(folder, &mut files)?;
    }
    files.sort();
    files.dedup();
    Ok(files)
}

fn add(folder: &Path, files: &mut Vec<Seen>) -> anyhow::Result<()> {
    let unreadable = || format!("the folder {} cannot be read; give folders of captures", folder.display());
    for entry in std::fs::read_dir(folder).with_context(unreadable)? {
        let entry = entry.with_context(unreadable)?;
        let path = entry.path();
        // A link may lead back to where it lies.
        if entry.file_type().with_context(unreadable)?.is_dir() {
            add(&path, files)?;
        } else if path.extension().is_some_and(|ending| ["mcap", "csv", "mf4"].iter().any(|known| ending == *known)) {
            let (bytes, written_ns) = entry.metadata().map_or((0, 0), |metadata| {
                let written = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
                (metadata.len(), written.map_or(0, |time| time.as_nanos()))
            });
            files.push(Seen { path, bytes, written_ns });
        }
    }
    Ok(())
}
