//! The files of a part.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, bail};
use archive::testers::{ColumnChoice, Curve};

/// Endings of the files that a folder is read for.
const ENDINGS: [&str; 4] = ["csv", "json", "mcap", "txt"];

/// The given files, and in place of a folder the captures in it, by name.
///
/// # Errors
/// For a folder that cannot be read, or that holds none.
pub fn files_of(given: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for path in given {
        if path.is_dir() { files.extend(files_in(path)?) } else { files.push(path.clone()) }
    }
    Ok(files)
}

/// The captures of a folder, by name.
fn files_in(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder).with_context(|| format!("{} cannot be read", folder.display()))?;
    let paths: Result<Vec<PathBuf>, _> = entries.map(|entry| Ok::<_, std::io::Error>(entry?.path())).collect();
    let mut paths = paths.with_context(|| format!("{} cannot be read", folder.display()))?;
    paths.retain(|path| path.extension().is_some_and(|ending| ENDINGS.iter().any(|known| ending == *known)));
    paths.sort();
    if paths.is_empty() {
        bail!("{} holds no file that ends in .{}", folder.display(), ENDINGS.join(", ."));
    }
    Ok(paths)
}

/// The curve of each file.
///
/// # Errors
/// One sentence on what is wrong with a file.
pub fn curves(files: &[PathBuf], choice: Option<&ColumnChoice>) -> anyhow::Result<Vec<Curve>> {
    files.iter().map(|file| Ok(loaded_capture::load_curve(file, choice)?)).collect()
}
