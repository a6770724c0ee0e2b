//! One run at a time on a rig: on its runtime directory, and on its device.

use std::fs::{File, OpenOptions};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::{Read as _, Seek as _, Write as _};
use std::os::linux::net::SocketAddrExt as _;
use std::os::unix::net::{SocketAddr, UnixListener};
use std::path::Path;

use nix::fcntl::{Flock, FlockArg};
use shared_types::rig;

/// Holds the rig; the kernel lets go of it when the process ends, however it ends.
#[derive(Debug)]
pub struct RigLock {
    _lock: Flock<File>,
}

/// Why the rig could not be had.
#[derive(Debug, thiserror::Error)]
pub enum RigLockError {
    /// Another process has it.
    #[error("the rig is in use by process {holder}; wait for its run to end, or stop it")]
    InUse {
        /// Process id of the holder, or "unknown".
        holder: String,
    },
    /// Another process has its device.
    #[error("the rig '{rig}' is in use: another run holds its device {device}; wait for that run to end, or stop it")]
    DeviceInUse {
        /// The rig's name.
        rig: String,
        /// What is held.
        device: String,
    },
    /// The device cannot be held.
    #[error("the device {device} of the rig '{rig}' cannot be locked ({reason}); choose another name for `device`")]
    Device {
        /// The rig's name.
        rig: String,
        /// What was to be held.
        device: String,
        /// The system's word for it.
        reason: std::io::Error,
    },
    /// The lock file cannot be used.
    #[error("the rig's lock in {directory} cannot be used ({reason}); check the folder's permissions")]
    Unusable {
        /// The runtime directory.
        directory: String,
        /// The system's word for it.
        reason: std::io::Error,
    },
}

impl RigLock {
    /// Takes the rig.
    ///
    /// # Errors
    /// [`RigLockError`] when another process has it or the lock file cannot be used.
    pub fn take() -> Result<Self, RigLockError> {
        let unusable = |reason: std::io::Error| RigLockError::Unusable {
            directory: rig::runtime_dir().display().to_string(),
            reason,
        };
        let path = rig::create_runtime_dir().map_err(unusable)?.join("rig.lock");
        let file =
            OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path).map_err(unusable)?;
        let mut lock = match Flock::lock(file, FlockArg::LockExclusiveNonblock) {
            Ok(lock) => lock,
            Err((mut file, nix::errno::Errno::EWOULDBLOCK)) => {
                let mut holder = String::new();
                let _ = file.read_to_string(&mut holder);
                let holder = if holder.trim().is_empty() { "unknown".to_owned() } else { holder.trim().to_owned() };
                return Err(RigLockError::InUse { holder });
            }
            Err((_, error)) => return Err(unusable(error.into())),
        };
        lock.set_len(0).map_err(unusable)?;
        lock.rewind().map_err(unusable)?;
        write!(lock, "{}", std::process::id()).map_err(unusable)?;
        Ok(Self { _lock: lock })
    }
}

/// Holds a device, whatever the runtime directory; the kernel lets go of it when the process ends, however it ends.
///
/// An abstract socket's name is taken once on a machine, by whichever user, and leaves no file behind (unix(7)).
#[derive(Debug)]
pub struct DeviceLock {
    _name: UnixListener,
}

impl DeviceLock {
    /// Takes the device of a rig; of a path, the file that it leads to.
    ///
    /// # Errors
    /// [`RigLockError`] when another process has it.
    pub fn take(rig: &str, device: &str) -> Result<Self, RigLockError> {
        let mut hasher = DefaultHasher::new();
        let file = if device.contains('/') { std::fs::canonicalize(device).ok() } else { None };
        file.as_deref().unwrap_or(Path::new(device)).hash(&mut hasher);
        // Hashed, since a socket's name has at most 107 bytes.
        let name = format!("haptic-camera/device/{:016x}", hasher.finish());
        let bound = SocketAddr::from_abstract_name(name).and_then(|address| UnixListener::bind_addr(&address));
        bound.map(|listener| Self { _name: listener }).map_err(|reason| {
            let (rig, device) = (rig.to_owned(), device.to_owned());
            match reason.kind() {
                std::io::ErrorKind::AddrInUse => RigLockError::DeviceInUse { rig, device },
                _ => RigLockError::Device { rig, device, reason },
            }
        })
    }
}
