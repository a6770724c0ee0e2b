//! Room in shared memory, reserved before it is needed.
//!
//! iceoryx2 makes its segments sparse: a page is taken when it is first written, and where there is none left then, the
//! kernel ends the process (SIGBUS). So a rig asks for room before it begins, and its ports have their pages from the
//! start.

use std::fs::{File, Metadata};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _};

use nix::errno::Errno;
use nix::fcntl::{FallocateFlags, OFlag, fallocate};

use crate::clean_up::files_in_shared_memory;
use crate::rig::runtime_dir;
use crate::services::{SAMPLE_QUEUE_BLOCKS, SAMPLES_PER_BLOCK, ServiceError};
use crate::shared_memory_dir::SHARED_MEMORY;
use crate::{BlockHeader, Sample};

/// Most bytes that blocks of samples take. As many blocks can be out at once as the slowest consumer's queue holds, the history
/// among them; a share of that number is on loan besides. The pool has several times as many blocks, for six consumers that lag
/// behind by different ones, but it is used from its beginning.
const SAMPLE_BLOCKS_BYTES: usize = (SAMPLE_QUEUE_BLOCKS + SAMPLE_QUEUE_BLOCKS / 64) * BLOCK_BYTES;
/// A block with its headers and its place in the pool's books.
const BLOCK_BYTES: usize = SAMPLES_PER_BLOCK * size_of::<Sample>() + size_of::<BlockHeader>() + 64;
/// All other ports and the connections between them; most of it is for the models of a replay.
const OTHER_PORTS_BYTES: usize = 40 << 20;
/// What counts as full: less than a process takes to attach to a rig.
const FULL_BYTES: u64 = 1 << 20;
/// Files that a process of the rig comes to open: every segment is one.
const FEW_DESCRIPTORS: u64 = 100;
/// Shared memory that a rig takes at most, bytes.
pub const NEEDED_BYTES: u64 = (SAMPLE_BLOCKS_BYTES + OTHER_PORTS_BYTES) as u64;

/// Makes sure, before anything of the rig is made, that there is room for all of it.
///
/// # Errors
/// [`ServiceError::NoRoom`].
pub fn check_room() -> Result<(), ServiceError> {
    // What a run that was killed has left is taken away or used again.
    let of_rig: u64 = rig_files().filter_map(|path| path.metadata().ok()).map(|file| file.blocks() * 512).sum();
    let free = free_bytes();
    if free + of_rig >= NEEDED_BYTES { Ok(()) } else { Err(ServiceError::NoRoom { needed: NEEDED_BYTES, free }) }
}

/// Makes sure that there is any room to attach to a rig that nobody has made so far.
///
/// # Errors
/// [`ServiceError::NoRoom`].
pub(crate) fn check_any_room() -> Result<(), ServiceError> {
    let free = free_bytes();
    let is_made = rig_files().next().is_some();
    if is_made || free >= FULL_BYTES { Ok(()) } else { Err(ServiceError::NoRoom { needed: NEEDED_BYTES, free }) }
}

/// Takes every page that the ports made so far can come to need.
///
/// # Errors
/// [`ServiceError::NoRoom`].
pub(crate) fn reserve() -> Result<(), ServiceError> {
    for path in rig_files() {
        // The others must not even be opened: to close a file lets go of the locks on it (fcntl(2)), and by such a lock
        // iceoryx2 knows that a process lives.
        let is_sparse = |file: &Metadata| file.is_file() && file.blocks() * 512 < file.len();
        if !path.symlink_metadata().is_ok_and(|file| is_sparse(&file)) {
            continue;
        }
        // Another process of the rig may have taken it away, or not have given it its size so far.
        let opened = File::options().write(true).custom_flags(OFlag::O_NOFOLLOW.bits()).open(&path);
        let Ok(file) = opened else { continue };
        let length = file.metadata().map_or(0, |file| file.len()).min(SAMPLE_BLOCKS_BYTES as u64);
        let length = i64::try_from(length).unwrap_or(i64::MAX);
        if length > 0 && fallocate(&file, FallocateFlags::FALLOC_FL_KEEP_SIZE, 0, length) == Err(Errno::ENOSPC) {
            return Err(ServiceError::NoRoom { needed: NEEDED_BYTES, free: free_bytes() });
        }
    }
    Ok(())
}

fn rig_files() -> impl Iterator<Item = std::path::PathBuf> {
    files_in_shared_memory(&runtime_dir()).into_iter()
}

/// Room that is left, bytes; as much as there can be where the system does not tell.
fn free_bytes() -> u64 {
    nix::sys::statvfs::statvfs(SHARED_MEMORY)
        .map_or(u64::MAX / 2, |there| there.blocks_available() * there.fragment_size())
}

/// What to do about a port that iceoryx2 could not make; it does not say why.
pub(crate) fn remedy() -> &'static str {
    let limit =
        nix::sys::resource::getrlimit(nix::sys::resource::Resource::RLIMIT_NOFILE).map_or(u64::MAX, |(soft, _)| soft);
    let open = std::fs::read_dir("/proc/self/fd").map_or(limit, |entries| entries.count() as u64);
    if open.saturating_add(FEW_DESCRIPTORS) > limit {
        "this process has too few open files left: raise the limit with `ulimit -n 1024`"
    } else if free_bytes() < FULL_BYTES {
        "/dev/shm is full: remove files from it"
    } else {
        "check the permissions of /dev/shm and of the rig's runtime directory"
    }
}
