//! One part of a recording: a file, its writer, and the thread that brings it to the disk.

use std::fs::File;
use std::io::BufWriter;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use archive::{CaptureWriter, WriteSummary};
use shared_types::RunDescription;

/// Bytes gathered before the operating system is called; a chunk is a few times as long.
const BUFFER_BYTES: usize = 256 * 1024;

/// Interval between requests to sync the file to the disk: what a power cut can cost. Writing waits during a sync, so one does
/// not follow every chunk.
const SYNC_INTERVAL: Duration = Duration::from_millis(400);

/// A part that is being written.
pub(crate) struct Part {
    pub(crate) path: PathBuf,
    pub(crate) writer: CaptureWriter<BufWriter<File>>,
    file: File,
    disk: Disk,
    /// Time of the last request to sync the file.
    asked: Instant,
}

/// What a flush did and found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Flushed {
    /// A sync that was requested earlier has completed.
    pub(crate) taken: bool,
    /// A sync of everything written so far was requested.
    pub(crate) asked: bool,
}

impl Part {
    /// Begins a part in a file that must not exist yet.
    pub(crate) fn create(path: &Path, run: &RunDescription) -> anyhow::Result<Self> {
        let place = || path.display().to_string();
        // Read, too: what is removed while it is written can still be saved through this handle.
        let file = File::options().read(true).write(true).create_new(true).open(path).with_context(place)?;
        let disk = Disk::new(file.try_clone().with_context(place)?).with_context(place)?;
        let buffer = BufWriter::with_capacity(BUFFER_BYTES, file.try_clone().with_context(place)?);
        let writer = CaptureWriter::new(buffer, run).with_context(place)?;
        let mut part = Self { path: path.to_owned(), writer, file, disk, asked: Instant::now() };
        part.flush()?;
        archive::whole_file::sync_directory(path)?;
        Ok(part)
    }

    /// Closes the chunk, hands it to the operating system and has it brought to the disk, without
    /// waiting for the disk.
    pub(crate) fn flush(&mut self) -> anyhow::Result<Flushed> {
        let place = || self.path.display().to_string();
        self.writer.flush().with_context(place)?;
        let taken = self.disk.has_taken().with_context(place)?;
        let asked = self.asked.elapsed() >= SYNC_INTERVAL && self.disk.ask();
        if asked {
            self.asked = Instant::now();
        }
        ensure!(!self.has_vanished(), "{} was removed or moved while it was written", self.path.display());
        Ok(Flushed { taken, asked })
    }

    /// True when the file no longer lies where it was made: it is gone once it is closed.
    fn has_vanished(&self) -> bool {
        match (self.file.metadata(), self.path.metadata()) {
            (Ok(ours), Ok(there)) => (ours.dev(), ours.ino()) != (there.dev(), there.ino()),
            (_, Err(error)) => error.kind() == std::io::ErrorKind::NotFound,
            (Err(_), Ok(_)) => false,
        }
    }

    /// Gives the part up after a failure; returns its file if that has vanished from its place, so that it can be saved
    /// elsewhere.
    pub(crate) fn give_up(self) -> Option<File> {
        let vanished = self.has_vanished();
        let Self { path: _, writer, file, disk, asked: _ } = self;
        // Dropping the writer tries to end the file. That may fail: flushed chunks can be read without an end.
        drop(writer);
        drop(disk);
        vanished.then_some(file)
    }

    /// Ends the part and waits until it is on the disk.
    pub(crate) fn finish(self) -> anyhow::Result<(PathBuf, WriteSummary)> {
        let Self { path, writer, file: _, disk, asked: _ } = self;
        let (summary, buffer) = writer.finish().with_context(|| path.display().to_string())?;
        let file = buffer
            .into_inner()
            .map_err(std::io::IntoInnerError::into_error)
            .with_context(|| path.display().to_string())?;
        disk.join().with_context(|| path.display().to_string())?;
        file.sync_all().with_context(|| path.display().to_string())?;
        Ok((path, summary))
    }
}

/// Syncs a file to the disk on a thread of its own, since a disk can take seconds; one request at a time.
struct Disk {
    requests: SyncSender<()>,
    results: Receiver<std::io::Result<()>>,
    at_work: bool,
    thread: JoinHandle<()>,
}

impl Disk {
    fn new(file: File) -> std::io::Result<Self> {
        let (requests, wanted) = sync_channel::<()>(1);
        let (report, results) = channel();
        let thread = std::thread::Builder::new().name("disk".to_owned()).spawn(move || {
            while wanted.recv().is_ok() {
                // The other end may be gone already; then finishing reports a failure.
                if report.send(file.sync_data()).is_err() {
                    break;
                }
            }
        })?;
        Ok(Self { requests, results, at_work: false, thread })
    }

    /// Requests a sync, unless one is under way; returns whether it was requested.
    fn ask(&mut self) -> bool {
        let asked = !self.at_work && self.requests.try_send(()).is_ok();
        self.at_work |= asked;
        asked
    }

    /// Whether the requested sync has completed since the last call.
    fn has_taken(&mut self) -> std::io::Result<bool> {
        let Ok(result) = self.results.try_recv() else { return Ok(false) };
        self.at_work = false;
        result.map(|()| true)
    }

    /// Waits for the sync under way. The system tells of a failure once, so that a later sync does not know of it.
    fn join(self) -> std::io::Result<()> {
        let Self { requests, results, at_work: _, thread } = self;
        drop(requests);
        // The thread does not panic.
        let _ = thread.join();
        results.into_iter().collect()
    }
}
