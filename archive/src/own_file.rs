//! Files that the user made himself, where others can make some too.

use std::fs::File;
use std::io::{Error, ErrorKind};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};
use std::path::Path;

use nix::libc::{O_NOFOLLOW, O_NONBLOCK};
use nix::unistd::geteuid;

use crate::whole_file::folder_of;

/// Opens a regular file of the calling process's user for reading.
///
/// Nothing else has an effect: a link is not followed, and a pipe that nobody writes to is not waited for.
///
/// # Errors
/// The system's, and [`ErrorKind::PermissionDenied`] for what is another user's or no file.
pub fn open(path: &Path) -> std::io::Result<File> {
    let file = File::options().read(true).custom_flags(O_NOFOLLOW | O_NONBLOCK).open(path)?;
    let found = file.metadata()?;
    if !found.is_file() {
        return Err(Error::new(ErrorKind::PermissionDenied, "it is no file"));
    }
    if found.uid() != geteuid().as_raw() && !is_owner_of_new_files(found.uid(), folder_of(path)) {
        return Err(Error::new(ErrorKind::PermissionDenied, format!("it belongs to user {}", found.uid())));
    }
    Ok(file)
}

/// Whether new files of the calling process in `folder` belong to user `owner`. A memory stick's file system may have no owners; a network
/// file system may show an administrator another owner.
fn is_owner_of_new_files(owner: u32, folder: &Path) -> bool {
    tempfile::tempfile_in(folder).and_then(|file| file.metadata()).is_ok_and(|made| made.uid() == owner)
}
