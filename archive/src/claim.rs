//! Names that no two runs share, however close together they begin.

use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::parts;

/// A claim on the name of an archive, and on the same name with other endings for its results: no other run uses the name.
///
/// A hidden file holds the claim until the archive exists. Dropping the claim or calling [`release`] removes that file.
#[derive(Debug)]
pub struct Claim {
    archive: PathBuf,
}

impl Claim {
    /// Claims the first free name in `folder`: `STEM.mcap`, else `STEM_02.mcap` and so on. The underscore makes the numbered names sort
    /// behind `STEM.mcap`; a dash would not.
    ///
    /// If the folder cannot be written to, returns an unclaimed name: no other run writes there, and the recorder goes elsewhere.
    #[must_use]
    pub fn take(folder: &Path, stem: &str) -> Self {
        let mut number = 1;
        loop {
            let archive = folder.join(format!("{}.mcap", numbered(stem, number)));
            number += 1;
            if File::create_new(holder(&archive)).is_err_and(|error| error.kind() == ErrorKind::AlreadyExists) {
                continue;
            }
            let claim = Self { archive };
            if !claim.is_used() {
                return claim;
            }
        }
    }

    /// The archive's name.
    #[must_use]
    pub fn archive(&self) -> &Path {
        &self.archive
    }

    /// Whether anything of an earlier run bears the name.
    fn is_used(&self) -> bool {
        let results = ["mcap", "toml", "html", "json"].map(|ending| self.archive.with_extension(ending));
        let first_part = parts::path(&self.archive, crate::whole_file::folder_of(&self.archive), 0);
        results.iter().chain([&first_part]).any(|path| path.symlink_metadata().is_ok())
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        release(&self.archive);
    }
}

/// Releases the claim on the name of an archive that exists, or that will never be written.
pub fn release(archive: &Path) {
    // Where it was never held there is nothing to remove.
    let _ = std::fs::remove_file(holder(archive));
}

/// Makes a folder of a name that no other run has: `STEM`, else `STEM_02` and so on.
///
/// # Errors
/// The system's.
pub fn folder(parent: &Path, stem: &str) -> std::io::Result<PathBuf> {
    std::fs::create_dir_all(parent)?;
    let mut number = 1;
    loop {
        let folder = parent.join(numbered(stem, number));
        match std::fs::create_dir(&folder) {
            Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
            made => return made.map(|()| folder),
        }
    }
}

/// The file that holds the name of an archive.
fn holder(archive: &Path) -> PathBuf {
    let stem = archive.file_stem().unwrap_or_default().to_string_lossy();
    archive.with_file_name(format!(".{stem}.incomplete"))
}

/// The `number`th name that begins with `stem`: the stem itself, then `STEM_02` and so on.
#[must_use]
pub fn numbered(stem: &str, number: u32) -> String {
    if number == 1 { stem.to_owned() } else { format!("{stem}_{number:02}") }
}
