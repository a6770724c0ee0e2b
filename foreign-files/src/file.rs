//! Opening and reading a file by a name that somebody gave.

use std::fs::{File, FileType, OpenOptions};
use std::io::{Error, ErrorKind, Read as _, Result};
use std::os::unix::fs::{FileTypeExt as _, OpenOptionsExt as _};
use std::path::Path;

/// Longest text that is read whole, bytes: ten times the largest model, a drawn table of 10 000 points.
const LONGEST_TEXT: u64 = 4 << 20;

/// Opens a file for reading; a folder, pipe, socket or device is refused at once instead of waited for.
///
/// # Errors
/// The system's, and [`ErrorKind::InvalidInput`] for what is no file.
pub fn open(path: &Path) -> Result<File> {
    refuse_other_kinds(std::fs::metadata(path)?.file_type())?;
    // The name may stand for something else by now, which must not keep the program waiting either.
    let file = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK).open(path)?;
    refuse_other_kinds(file.metadata()?.file_type())?;
    Ok(file)
}

/// Reads a file of text, such as a model or a calibration.
///
/// # Errors
/// As [`open`], and [`ErrorKind::InvalidData`] for what is too long or not UTF-8.
pub fn read_text(path: &Path) -> Result<String> {
    let mut bytes = Vec::new();
    open(path)?.take(LONGEST_TEXT + 1).read_to_end(&mut bytes)?;
    let unfit = |reason: String| Error::new(ErrorKind::InvalidData, reason);
    if bytes.len() as u64 > LONGEST_TEXT {
        return Err(unfit(format!("it is longer than {} MiB", LONGEST_TEXT >> 20)));
    }
    String::from_utf8(bytes).map_err(|_| unfit("it is not UTF-8 text".to_owned()))
}

fn refuse_other_kinds(kind: FileType) -> Result<()> {
    let what = match () {
        () if kind.is_file() => return Ok(()),
        () if kind.is_dir() => "a folder",
        () if kind.is_fifo() => "a pipe",
        () if kind.is_socket() => "a socket",
        () => "a device",
    };
    Err(Error::new(ErrorKind::InvalidInput, format!("it is {what}, not a file")))
}
