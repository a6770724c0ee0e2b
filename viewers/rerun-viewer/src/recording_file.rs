//! A rerun file that says when it could not be written: rerun's own logs that and goes on.

use std::fs::{File, OpenOptions};
use std::io::{self, Read as _};
use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{anyhow, ensure};
use parking_lot::Mutex;
use rerun::external::re_log_encoding::{EncodeError, Encoder, EncodingOptions};
use rerun::log::LogMsg;
use rerun::sink::CallbackSink;
use tempfile::{NamedTempFile, TempPath};

/// What every rerun file begins with.
const BEGINS_WITH: &[u8] = b"RRF2";

#[derive(Clone)]
pub struct RecordingFile {
    path: PathBuf,
    state: Arc<Mutex<State>>,
}

struct State {
    /// Until the file is finished or cannot be written.
    encoder: Option<Encoder<File>>,
    /// Where it is written and what it is to replace, which stays until this one is whole.
    replacement: Option<(TempPath, PathBuf)>,
    failure: Option<EncodeError>,
}

impl RecordingFile {
    /// Begins a file for our own user alone. Another rerun file at its place is replaced; anything else that holds data
    /// is not. Fails when it cannot be written, or there is a file of another kind.
    pub fn create(path: &Path) -> anyhow::Result<Self> {
        let name = path.display();
        ensure!(may_be_replaced(path), "{name} is no rerun file and is not overwritten; name another place");
        let (version, options) = (rerun::build_info().version, EncodingOptions::PROTOBUF_COMPRESSED);
        let begin = || {
            let (file, replacement) = open(path)?;
            let encoder = Some(Encoder::new_eager(version, options, file)?);
            anyhow::Ok(State { encoder, replacement, failure: None })
        };
        let state = begin().map_err(|error| cannot_be_written(path, &error))?;
        Ok(Self { path: path.to_owned(), state: Arc::new(Mutex::new(state)) })
    }

    /// Where a recording sends what is drawn.
    pub fn sink(&self) -> CallbackSink {
        let file = self.clone();
        CallbackSink::new(move |messages| file.state.lock().write(messages))
    }

    /// Whether all that was drawn so far could be written. An error says why it could not.
    pub fn check(&self) -> anyhow::Result<()> {
        let failure = self.state.lock().failure.take();
        failure.map_or(Ok(()), |failure| Err(cannot_be_written(&self.path, &failure.into())))
    }

    /// Writes what rerun needs to seek in the file, and waits until all of it is on the disk.
    /// Fails when any part of it could not be written.
    pub fn finish(&self) -> anyhow::Result<()> {
        self.check()?;
        self.state.lock().finish().map_err(|error| cannot_be_written(&self.path, &error))
    }
}

impl State {
    fn write(&mut self, messages: &[LogMsg]) {
        let Some(encoder) = &mut self.encoder else { return };
        self.failure = messages.iter().try_for_each(|message| encoder.append(message).map(drop)).err();
        if self.failure.is_some() {
            // One that is dropped tries to write its end, and complains itself.
            let _ = self.encoder.take().map(Encoder::into_inner);
            self.replacement = None;
        }
    }

    fn finish(&mut self) -> anyhow::Result<()> {
        let Some(mut encoder) = self.encoder.take() else { return Ok(()) };
        let replacement = self.replacement.take();
        match encoder.finish().and(encoder.into_inner())?.sync_all() {
            // A pipe or a device has nothing to wait for.
            Err(error) if error.kind() == io::ErrorKind::InvalidInput => {}
            synced => synced?,
        }
        if let Some((written, place)) = replacement {
            written.persist(place).map_err(|failed| failed.error)?;
        }
        Ok(())
    }
}

/// Opens the file, closed to others: at its place, or beside it where that is taken.
fn open(path: &Path) -> io::Result<(File, Option<(TempPath, PathBuf)>)> {
    if has_content(path) {
        let place = path.canonicalize()?;
        let mut beside = tempfile::Builder::new();
        beside.prefix(".haptic-camera-").suffix(".incomplete");
        let folder = place.parent().unwrap_or(Path::new("/"));
        let refused = |error: io::Error| {
            let reason = format!("its folder must be writable, since a new file is made beside the old one: {error}");
            io::Error::new(error.kind(), reason)
        };
        let (file, written) = beside.tempfile_in(folder).map(NamedTempFile::into_parts).map_err(refused)?;
        return Ok((file, Some((written, place))));
    }
    let file = OpenOptions::new().write(true).create(true).truncate(true).mode(0o600).open(path)?;
    if file.metadata()?.is_file() {
        file.set_permissions(std::fs::Permissions::from_mode(0o600))?;
    }
    Ok((file, None))
}

fn has_content(path: &Path) -> bool {
    path.metadata().is_ok_and(|found| found.is_file() && found.len() > 0)
}

/// Whether there is nothing at `path`, a device or pipe, an empty file, or a rerun file.
fn may_be_replaced(path: &Path) -> bool {
    if !has_content(path) {
        return true;
    }
    let mut beginning = [0; BEGINS_WITH.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut beginning)).is_ok() && beginning == *BEGINS_WITH
}

fn cannot_be_written(path: &Path, error: &anyhow::Error) -> anyhow::Error {
    let (name, cause) = (path.display(), error.root_cause());
    anyhow!("{name} cannot be written ({cause}); free space on its disk or name another place")
}
