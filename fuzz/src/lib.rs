//! What the fuzz targets do alike: memory bounded by the size of the input, and files read and recovered.

use std::alloc::System;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use archive::recover::{Unchecked, recover_stream};
use archive::testers::Curve;
use archive::{ArchiveError, Capture};
use cap::Cap;

/// Memory that any input may take, bytes, besides [`MEMORY_SHARE`].
const MEMORY: usize = 1_000_000_000;
/// Bytes of memory that each byte of input may take.
const MEMORY_SHARE: usize = 10;

/// An allocation beyond the limit fails, which ends the process with the input that asked for it.
#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Does something with an input of `length` bytes, in as much memory as its size permits beyond what is held already.
pub fn bounded(length: usize, work: impl FnOnce()) {
    ALLOCATOR.set_limit(ALLOCATOR.allocated() + MEMORY + MEMORY_SHARE * length).expect("more than is allocated");
    work();
    ALLOCATOR.set_limit(usize::MAX).expect("no limit");
}

/// Bytes as a whole file, read and recovered; whatever they are, neither may panic, and what recovery
/// gives is an archive that recovers again without loss.
pub fn read_and_recover(file: &[u8]) {
    let path = own_path();
    std::fs::write(path, file).expect("a place for the file");
    if let Err(error) = Capture::load(path) {
        assert!(!error.to_string().is_empty());
    }
    let mut whole = Cursor::new(Vec::new());
    let Ok(first) = recover_stream(file, &mut whole, Path::new("file"), Unchecked::Keep) else { return };
    let whole = whole.into_inner();
    let mut again = Cursor::new(Vec::new());
    let second = match recover_stream(&whole[..], &mut again, Path::new("whole"), Unchecked::LeaveOut) {
        Ok(second) => second,
        // Without a message there is no chunk, and so nothing to recover from.
        Err(ArchiveError::NothingToRecover { .. }) if first.messages_kept == 0 => return,
        Err(error) => panic!("what was recovered is broken: {error}"),
    };
    assert_eq!(second.samples_kept, first.samples_kept);
    assert_eq!((second.bytes_dropped, second.finished), (0, true));
    std::fs::write(path, &whole).expect("a place for the file");
    if let Err(error @ (ArchiveError::Truncated { .. } | ArchiveError::NotACapture { .. })) = Capture::load(path) {
        panic!("what was recovered is broken: {error}");
    }
}

/// Bytes as a measurement in ASAM MDF, whose first letters they are given; whatever they are, reading must end with a curve that
/// is whole or with a sentence.
pub fn read_measurement(bytes: &[u8]) {
    let path = own_path();
    std::fs::write(path, [b"MDF     ", bytes].concat()).expect("a place for the file");
    match Curve::load(path, None) {
        Ok(curve) => {
            assert!(
                curve.position.len() == curve.load.len() && curve.t_s.is_none_or(|t_s| t_s.len() == curve.load.len())
            );
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A file in memory of this process's own.
fn own_path() -> &'static Path {
    static PATH: OnceLock<PathBuf> = OnceLock::new();
    PATH.get_or_init(|| PathBuf::from(format!("/dev/shm/haptic-camera-fuzz-{}", std::process::id())))
}
