//! Files that are either there whole or not at all, and that take nothing else's place.

use std::fs::{File, Metadata, Permissions};
use std::io::{BufWriter, ErrorKind, Read as _};
use std::os::fd::AsFd as _;
use std::os::unix::fs::{FileTypeExt as _, MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use nix::unistd::geteuid;

use crate::error::ArchiveError;
use crate::own_file;

/// What an output may replace. It may always replace an empty file of the user's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Replace {
    /// Nothing.
    Nothing,
    /// An earlier output of the same kind: a file of the user's own with this text in its first 64 KiB.
    Marked(&'static str),
    /// Any file.
    Anything,
}

/// Paths that may lead to a file but are written to as streams.
const STANDARD_OUTPUT: &str = "/dev/stdout";
const STANDARD_ERROR: &str = "/dev/stderr";

/// How far into a file its mark may lie, bytes.
const MARK_WITHIN: u64 = 64 * 1024;

/// What is in the way of an output that may replace earlier ones of its kind, and of an output that may replace nothing.
const FOREIGN: &str = "an existing file, not an earlier output of the same kind";
const TAKEN: &str = "there already";

/// Writes a file under a temporary name beside `path`, then puts it in its place.
///
/// The content is on the disk before the name is: a crash leaves the old file or the new one. What lies at `path` and is not to
/// be replaced stays as it is. A device, a pipe or `/dev/stdout` is written to as it stands.
///
/// # Errors
/// What `write` reports, [`ArchiveError::Occupied`], or [`ArchiveError::Unwritable`] when the operating system refuses. The
/// temporary file is removed then.
pub fn write_whole<Written>(
    path: &Path,
    replace: Replace,
    write: impl FnOnce(BufWriter<File>) -> Result<Written, ArchiveError>,
) -> Result<Written, ArchiveError> {
    let refused = |error| unwritable(path, &error);
    let into = |file| BufWriter::with_capacity(1 << 20, file);
    let (place, free) = match place(path, replace)? {
        Place::Stream => return write(into(open_stream(path).map_err(refused)?)),
        Place::Free => (path.to_owned(), true),
        Place::Taken(there) => (there, false),
    };
    // Whoever could read a file that is replaced still can.
    let mode = if free { Permissions::from_mode(0o666) } else { place.metadata().map_err(refused)?.permissions() };
    let temporary = tempfile::Builder::new()
        .prefix(".haptic-camera-")
        .suffix(".incomplete")
        .permissions(mode)
        .tempfile_in(folder_of(&place))
        .map_err(|error| no_place(path, &error))?;
    let written = write(into(temporary.as_file().try_clone().map_err(refused)?))?;
    temporary.as_file().sync_all().map_err(refused)?;
    let persisted = if free { temporary.persist_noclobber(&place) } else { temporary.persist(&place) };
    persisted.map_err(|failed| not_in_place(path, failed.error))?;
    sync_directory(&place)?;
    Ok(written)
}

/// [`write_whole`] for content that is in memory.
///
/// # Errors
/// As [`write_whole`].
pub fn write_bytes(path: &Path, replace: Replace, content: &[u8]) -> Result<(), ArchiveError> {
    use std::io::Write as _;
    write_whole(path, replace, |mut place| {
        let written = place.write_all(content).and_then(|()| place.flush());
        written.map_err(|error| unwritable(path, &error))
    })
}

fn unwritable(path: &Path, reason: &impl ToString) -> ArchiveError {
    ArchiveError::Unwritable { path: path.to_owned(), reason: reason.to_string() }
}

/// Why no file can be created in the folder. The text of `error` is not used, since it names the temporary file.
fn no_place(path: &Path, error: &std::io::Error) -> ArchiveError {
    match error.kind() {
        ErrorKind::NotFound => unwritable(path, &"there is no such folder"),
        kind => unwritable(path, &kind),
    }
}

/// Whether `path` could be written as things stand.
///
/// # Errors
/// [`ArchiveError::Occupied`] where something lies there that is not to be replaced.
pub fn check(path: &Path, replace: Replace) -> Result<(), ArchiveError> {
    place(path, replace).map(drop)
}

/// Where an output goes.
enum Place {
    /// Into something that is no file.
    Stream,
    /// To a name that nothing has.
    Free,
    /// In the place of a file; its name behind all links.
    Taken(PathBuf),
}

fn place(path: &Path, replace: Replace) -> Result<Place, ArchiveError> {
    let refused = |error| ArchiveError::file(path, error);
    let occupied = |by| Err(ArchiveError::Occupied { path: path.to_owned(), by });
    if [STANDARD_OUTPUT, STANDARD_ERROR].iter().any(|name| path == Path::new(name)) {
        return Ok(Place::Stream);
    }
    let Ok(entry) = path.symlink_metadata() else { return Ok(Place::Free) };
    if !is_trusted(&entry) && entry.is_symlink() {
        return occupied("a link of another user's");
    }
    let found = match path.metadata() {
        Ok(found) => found,
        Err(error) if error.kind() == ErrorKind::NotFound => return occupied("a link to nothing"),
        Err(error) => return Err(refused(error)),
    };
    let kind = found.file_type();
    let is_stream = kind.is_char_device() || kind.is_block_device() || kind.is_fifo() || kind.is_socket();
    if found.is_dir() {
        occupied("a folder")
    } else if is_stream && !is_trusted(&found) {
        occupied("a pipe of another user's")
    } else if is_stream {
        Ok(Place::Stream)
    } else if replace == Replace::Anything || is_replaceable(path, replace).map_err(refused)? {
        path.canonicalize().map(Place::Taken).map_err(refused)
    } else {
        occupied(if replace == Replace::Nothing { TAKEN } else { FOREIGN })
    }
}

/// Whether the user himself or the system made it.
fn is_trusted(found: &Metadata) -> bool {
    found.uid() == 0 || found.uid() == geteuid().as_raw()
}

/// Opens a stream for writing. Standard output and standard error are duplicated, not opened anew, so that nothing is overwritten.
fn open_stream(path: &Path) -> std::io::Result<File> {
    match path.to_str() {
        Some(STANDARD_OUTPUT) => Ok(std::io::stdout().as_fd().try_clone_to_owned()?.into()),
        Some(STANDARD_ERROR) => Ok(std::io::stderr().as_fd().try_clone_to_owned()?.into()),
        _ => File::options().write(true).open(path),
    }
}

/// Whether a file is the user's own, and empty or marked.
fn is_replaceable(path: &Path, replace: Replace) -> std::io::Result<bool> {
    let file = match own_file::open(&path.canonicalize()?) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::PermissionDenied => return Ok(false),
        Err(error) => return Err(error),
    };
    if file.metadata()?.len() == 0 {
        return Ok(true);
    }
    let Replace::Marked(mark) = replace else { return Ok(false) };
    let mut head = Vec::new();
    file.take(MARK_WITHIN).read_to_end(&mut head)?;
    Ok(head.windows(mark.len()).any(|window| window == mark.as_bytes()))
}

/// Gives a finished file its name, unless something has it, and makes the new name durable.
///
/// # Errors
/// [`ArchiveError::Occupied`], or [`ArchiveError::File`] when the operating system refuses; the file stays where it was.
pub fn put_in_place(from: &Path, to: &Path) -> Result<(), ArchiveError> {
    let finished = tempfile::TempPath::try_from_path(from).map_err(|error| ArchiveError::file(from, error))?;
    if let Err(failed) = finished.persist_noclobber(to) {
        // The finished file is not temporary: it must not be removed when `failed` is dropped.
        let _ = failed.path.keep();
        return Err(not_in_place(to, failed.error));
    }
    sync_directory(to)
}

fn not_in_place(path: &Path, error: std::io::Error) -> ArchiveError {
    if error.kind() == ErrorKind::AlreadyExists {
        ArchiveError::Occupied { path: path.to_owned(), by: TAKEN }
    } else {
        ArchiveError::file(path, error)
    }
}

/// Makes the entry of `path` in its directory durable.
///
/// # Errors
/// [`ArchiveError::File`] when the operating system refuses.
pub fn sync_directory(path: &Path) -> Result<(), ArchiveError> {
    let parent = folder_of(path);
    File::open(parent).and_then(|directory| directory.sync_all()).map_err(|error| ArchiveError::file(parent, error))
}

/// The directory that `path` lies in.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// `path` with `ending` appended to its file name.
#[must_use]
pub fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}
