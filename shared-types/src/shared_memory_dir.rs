//! The folder that holds a rig's shared memory.
//!
//! It lies below `/dev/shm`; its name is drawn by lot and noted in the runtime directory. Only the user may enter either
//! folder: nothing that another user makes, names or removes meets a rig, and two rigs never meet.

use std::fs::File;
use std::path::{Path, PathBuf};

use nix::fcntl::{Flock, FlockArg};
use nix::unistd::mkdtemp;

use crate::rig::{create_runtime_dir, open_private_dir};
use crate::wire::fnv1a;

/// Where POSIX shared memory lies on Linux.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// In the runtime directory: a link to the folder in shared memory.
const SHARED_MEMORY_LINK: &str = "shared-memory";

/// Keeps other processes of the rig from attaching to its folder in shared memory, from making and from removing it.
#[derive(Debug)]
pub(crate) struct Held {
    runtime_dir: PathBuf,
    _lock: Flock<File>,
}

/// Waits until no other process makes, removes or attaches to the rig's folder in shared memory, and holds it.
///
/// # Errors
/// The system's, when the runtime directory cannot be used.
pub(crate) fn hold() -> std::io::Result<Held> {
    let runtime_dir = create_runtime_dir()?;
    let lock = Flock::lock(File::open(&runtime_dir)?, FlockArg::LockExclusive).map_err(|(_, error)| error)?;
    Ok(Held { runtime_dir, _lock: lock })
}

/// The folder that holds the rig's shared memory, made under a new name if there is none.
///
/// # Errors
/// The system's, when shared memory cannot be used.
pub(crate) fn create(Held { runtime_dir, .. }: &Held) -> std::io::Result<PathBuf> {
    let link = runtime_dir.join(SHARED_MEMORY_LINK);
    if let Some(directory) = std::fs::read_link(&link).ok().filter(|directory| open_private_dir(directory).is_ok()) {
        return Ok(directory);
    }
    forget(runtime_dir)?;
    let template = format!("{}XXXXXX", prefix(runtime_dir));
    let directory = mkdtemp(&Path::new(SHARED_MEMORY).join(template)).map_err(|error| {
        let reason = format!("no folder can be made in {SHARED_MEMORY} ({error}): check its permissions and its space");
        std::io::Error::new(std::io::Error::from(error).kind(), reason)
    })?;
    std::os::unix::fs::symlink(&directory, link)?;
    Ok(directory)
}

/// Removes the rig's folder in shared memory with everything in it.
///
/// # Errors
/// The system's.
pub(crate) fn remove(held: &Held) -> std::io::Result<()> {
    forget(&held.runtime_dir)
}

/// The folders in shared memory that the rig with this runtime directory made: one while it is attached to, and what is left of
/// earlier ones if the runtime directory was removed meanwhile.
pub(crate) fn of_rig(runtime_dir: &Path) -> Vec<PathBuf> {
    let prefix = prefix(runtime_dir);
    let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    let named = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix));
    named.map(|entry| entry.path()).filter(|path| open_private_dir(path).is_ok()).collect()
}

fn forget(runtime_dir: &Path) -> std::io::Result<()> {
    match std::fs::remove_file(runtime_dir.join(SHARED_MEMORY_LINK)) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
        _ => {}
    }
    of_rig(runtime_dir).iter().try_for_each(std::fs::remove_dir_all)
}

/// What the names of its folders begin with. Others may make such names too; theirs are not the rig's.
fn prefix(runtime_dir: &Path) -> String {
    let named = std::path::absolute(runtime_dir).unwrap_or_else(|_| runtime_dir.to_owned());
    format!("haptic-camera-{:016x}-", fnv1a(named.as_os_str().as_encoded_bytes()))
}
