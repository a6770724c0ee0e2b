//! Where a rig's lock lives, and the clocks that its processes share.
//!
//! A rig is named by its runtime directory, `$HAPTIC_CAMERA_RUNTIME_DIR`, or else a folder under `$XDG_RUNTIME_DIR` or in the
//! user's home, which only the user may enter.

use std::fs::File;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use nix::libc;
use nix::unistd::{User, geteuid};

/// Names the directory that stands for the rig.
pub const RUNTIME_DIR_VARIABLE: &str = "HAPTIC_CAMERA_RUNTIME_DIR";

/// Names the folder that timings go to, where somebody wants them: of each tick from the control loop, of each sample's
/// arrival from the consumers.
pub const TIMINGS_VARIABLE: &str = "HAPTIC_CAMERA_TIMINGS";

/// The directory that holds the rig's lock.
///
/// Without a variable it lies in the user's home as the system knows it, not in the temporary directory, where anybody could
/// have taken its name; a user without a home has nothing else.
#[must_use]
pub fn runtime_dir() -> PathBuf {
    if let Some(directory) = std::env::var_os(RUNTIME_DIR_VARIABLE) {
        return PathBuf::from(directory);
    }
    if let Some(directory) = std::env::var_os("XDG_RUNTIME_DIR") {
        return PathBuf::from(directory).join("haptic-camera");
    }
    let user = User::from_uid(geteuid()).ok().flatten();
    match user.map(|user| user.dir).filter(|home| home.is_dir()) {
        Some(home) => home.join(".local/state/haptic-camera"),
        None => std::env::temp_dir().join(format!("haptic-camera-{}", geteuid())),
    }
}

/// Creates the runtime directory, open to the user alone; one that is there is closed to others.
///
/// # Errors
/// The system's, when it cannot be created, and where it is a link or belongs to another user, who could stop the rig through it.
pub fn create_runtime_dir() -> std::io::Result<PathBuf> {
    let directory = runtime_dir();
    check_runtime_dir(&directory)?;
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&directory)?;
    open_private_dir(&directory).map_err(|error| {
        let reason = format!("{error}: remove it, or name another directory in {RUNTIME_DIR_VARIABLE}");
        std::io::Error::new(error.kind(), reason)
    })?;
    Ok(directory)
}

/// Opens a directory that only the calling process's user may enter; one of his that others may enter is closed to them.
///
/// # Errors
/// The system's, and where `path` is a link or belongs to another user. What that names stays as it is.
pub fn open_private_dir(path: &Path) -> std::io::Result<File> {
    let named = |error: std::io::Error| std::io::Error::new(error.kind(), format!("{}: {error}", path.display()));
    let directory =
        File::options().read(true).custom_flags(libc::O_DIRECTORY | libc::O_NOFOLLOW).open(path).map_err(named)?;
    let found = directory.metadata().map_err(named)?;
    if found.uid() != geteuid().as_raw() {
        let reason = format!("{} belongs to user {}", path.display(), found.uid());
        return Err(std::io::Error::new(std::io::ErrorKind::PermissionDenied, reason));
    }
    if found.mode() & 0o077 != 0 {
        directory.set_permissions(std::fs::Permissions::from_mode(0o700)).map_err(named)?;
    }
    Ok(directory)
}

/// Longest path of a runtime directory, bytes: with its name a socket in it has the 107 that Linux permits (unix(7)).
const LONGEST_RUNTIME_DIR: usize = 80;

/// Refuses a directory that no socket fits into, or whose name a message could not show as it is.
fn check_runtime_dir(directory: &Path) -> std::io::Result<()> {
    let bytes = directory.as_os_str().as_encoded_bytes();
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"/._-".contains(byte);
    if directory.is_absolute() && bytes.len() <= LONGEST_RUNTIME_DIR && bytes.iter().all(plain) {
        return Ok(());
    }
    let reason = format!(
        "the runtime directory {} is invalid: set {RUNTIME_DIR_VARIABLE} to an absolute path of at most \
         {LONGEST_RUNTIME_DIR} ASCII letters, digits and /._-",
        directory.display()
    );
    Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, reason))
}

/// Has the calling process make its files for its user alone: archives, models, the rig's lock.
pub fn keep_files_private() {
    nix::sys::stat::umask(nix::sys::stat::Mode::from_bits_truncate(0o077));
}

/// Whether a process has not ended yet. One that has, but that nobody has reaped, does not count.
#[must_use]
pub fn process_exists(process_id: u32) -> bool {
    process_state(process_id).is_some_and(|state| !matches!(state, 'Z' | 'X'))
}

/// The kernel's letter for what a process does (proc(5)): `R` runs, `S` sleeps, `D` waits for a disk, `T` is stopped,
/// `Z` has ended; `None` when there is none of this number.
#[must_use]
pub fn process_state(process_id: u32) -> Option<char> {
    let stat = std::fs::read_to_string(format!("/proc/{process_id}/stat")).ok()?;
    // `pid (name) state ...`; the name may hold anything, brackets too.
    stat.rsplit(')').next()?.trim_start().chars().next()
}

/// How long a process's main thread has waited for a processor in total (`/proc/PID/schedstat`, second field); zero where
/// the kernel keeps no such account.
#[must_use]
pub fn processor_wait(process_id: u32) -> Duration {
    let account = std::fs::read_to_string(format!("/proc/{process_id}/schedstat")).unwrap_or_default();
    Duration::from_nanos(account.split_whitespace().nth(1).and_then(|field| field.parse().ok()).unwrap_or(0))
}

/// CLOCK_MONOTONIC now, ns: the clock of every `monotonic_time_ns`.
#[must_use]
pub fn monotonic_time_ns() -> u64 {
    clock_ns(nix::time::ClockId::CLOCK_MONOTONIC)
}

/// The system clock now, ns since 1970.
#[must_use]
pub fn wall_clock_time_ns() -> u64 {
    clock_ns(nix::time::ClockId::CLOCK_REALTIME)
}

/// CPU time of the calling thread so far, ns.
#[must_use]
pub fn thread_cpu_time_ns() -> u64 {
    clock_ns(nix::time::ClockId::CLOCK_THREAD_CPUTIME_ID)
}

fn clock_ns(clock: nix::time::ClockId) -> u64 {
    // These clocks exist on every Linux; a failure cannot happen and would read as time 0.
    clock.now().map_or(0, |time| {
        u64::try_from(time.tv_sec()).unwrap_or(0) * 1_000_000_000 + u64::try_from(time.tv_nsec()).unwrap_or(0)
    })
}
