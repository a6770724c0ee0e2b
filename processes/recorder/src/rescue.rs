//! A part that was removed while it was written, saved elsewhere.

use std::fs::File;
use std::io::{Seek as _, Write as _};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;

use archive::parts::create_fallback_dir;

use crate::parts;

/// Copies the file of a removed part, which exists as long as it is open, on a thread of its own: the queues do not wait.
pub(crate) struct Rescue {
    path: PathBuf,
    copy: JoinHandle<std::io::Result<()>>,
}

impl Rescue {
    /// Begins to copy what was flushed of `removed` into a new part of `out` in the run's fallback folder; tells why it cannot.
    pub(crate) fn begin(removed: File, out: &Path, run_id: u64) -> Option<Self> {
        let begin = || {
            let path = parts::next_free(out, &create_fallback_dir(run_id)?)?;
            let place = File::options().write(true).create_new(true).open(&path)?;
            let copy = std::thread::Builder::new().name("rescue".to_owned()).spawn(move || copy(removed, place))?;
            anyhow::Ok(Self { path, copy })
        };
        begin().inspect_err(|error| tracing::error!("the removed recording cannot be saved: {error:#}")).ok()
    }

    /// Waits for the copy; tells if it failed.
    pub(crate) fn finish(self) {
        let Self { path, copy } = self;
        match copy.join() {
            Ok(Ok(())) => tracing::warn!("the removed recording is saved in {}", path.display()),
            Ok(Err(error)) => tracing::error!("{} has only a part of the removed recording: {error}", path.display()),
            Err(_panicked) => tracing::error!("{} has only a part of the removed recording", path.display()),
        }
    }
}

fn copy(mut removed: File, mut place: File) -> std::io::Result<()> {
    removed.rewind()?;
    std::io::copy(&mut removed, &mut place)?;
    place.flush()?;
    place.sync_all()
}
