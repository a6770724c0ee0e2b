//! The lease that a process holds from the process that started it.
//!
//! The process's standard input is a pipe that its starter holds open. When the starter ends, however it ends, or lets go,
//! the kernel closes the pipe, and the process reads its end. That also holds for a starter which was gone before the
//! process came to its first line, and for any of the starter's threads; a signal at the parent's death
//! (`PR_SET_PDEATHSIG`) covers neither.

use std::process::{Command, Stdio};

use nix::errno::Errno;
use nix::fcntl::{FcntlArg, OFlag, fcntl};

/// Says that standard input is a lease.
const LEASE_VARIABLE: &str = "HAPTIC_CAMERA_LEASE";

/// Makes the process that `command` starts run under a lease, which lasts as long as its starter holds its
/// [`stdin`](std::process::Child::stdin).
pub fn grant(command: &mut Command) {
    command.stdin(Stdio::piped()).env(LEASE_VARIABLE, "stdin");
}

/// The lease of the calling process.
#[derive(Debug)]
pub struct Lease(());

impl Lease {
    /// The lease under which this process was started; `None` for one that an operator started.
    ///
    /// # Errors
    /// The system's, when standard input cannot be asked without waiting.
    pub fn of_this_process() -> std::io::Result<Option<Self>> {
        if std::env::var_os(LEASE_VARIABLE).is_none() {
            return Ok(None);
        }
        let flags = OFlag::from_bits_retain(fcntl(std::io::stdin(), FcntlArg::F_GETFL)?);
        fcntl(std::io::stdin(), FcntlArg::F_SETFL(flags | OFlag::O_NONBLOCK))?;
        Ok(Some(Self(())))
    }

    /// Whether the starter is gone or has let go.
    #[must_use]
    pub fn has_ended(&self) -> bool {
        // Nothing is ever written. Whatever else goes wrong with the pipe, nobody holds this process by it.
        !matches!(nix::unistd::read(std::io::stdin(), &mut [0]), Ok(1) | Err(Errno::EAGAIN | Errno::EINTR))
    }
}
