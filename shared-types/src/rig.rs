//! Where a rig's lock and shared memory live, and the clocks that its processes share.
//!
//! A rig is named by its runtime directory, `$HAPTIC_CAMERA_RUNTIME_DIR`, or else a folder of the
//! user's own under `$XDG_RUNTIME_DIR` or the temporary directory. Everything of iceoryx2's that
//! belongs to the rig carries a prefix made from that path: two rigs never meet, and what one
//! leaves behind can be found.

use std::path::{Path, PathBuf};
use std::time::Duration;

/// Names the directory that stands for the rig.
pub const RUNTIME_DIR_VARIABLE: &str = "HAPTIC_CAMERA_RUNTIME_DIR";

/// Where POSIX shared memory lies on Linux.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Names the folder that timings go to, where somebody wants them: of each tick from the control loop, of each sample's
/// arrival from the consumers.
pub const TIMINGS_VARIABLE: &str = "HAPTIC_CAMERA_TIMINGS";

/// The directory that holds the rig's lock and iceoryx2's bookkeeping.
#[must_use]
pub fn runtime_dir() -> PathBuf {
    if let Some(directory) = std::env::var_os(RUNTIME_DIR_VARIABLE) {
        return PathBuf::from(directory);
    }
    if let Some(directory) = std::env::var_os("XDG_RUNTIME_DIR") {
        return PathBuf::from(directory).join("haptic-camera");
    }
    std::env::temp_dir().join(format!("haptic-camera-{}", nix::unistd::getuid()))
}

/// Creates the runtime directory, open to the user alone; one that is there is closed to others.
///
/// # Errors
/// The system's, when it cannot be created, and where it belongs to another user, who could stop the rig through it.
pub fn create_runtime_dir() -> std::io::Result<PathBuf> {
    use std::os::unix::fs::DirBuilderExt as _;
    let directory = runtime_dir();
    check_runtime_dir(&directory)?;
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&directory)?;
    close_to_others(&directory, 0o700)?;
    Ok(directory)
}

/// Longest path of a runtime directory, bytes: with its name a socket in it has the 107 that Linux permits (unix(7)).
const LONGEST_RUNTIME_DIR: usize = 80;

/// Refuses a directory in which iceoryx2 cannot work: it permits itself few characters, and sockets a short path.
fn check_runtime_dir(directory: &Path) -> std::io::Result<()> {
    let bytes = directory.as_os_str().as_encoded_bytes();
    let plain = |byte: &u8| byte.is_ascii_alphanumeric() || b"/._-".contains(byte);
    if directory.is_absolute() && bytes.len() <= LONGEST_RUNTIME_DIR && bytes.iter().all(plain) {
        return Ok(());
    }
    let reason = format!(
        "the runtime directory {} will not do: set {RUNTIME_DIR_VARIABLE} to an absolute path of at most \
         {LONGEST_RUNTIME_DIR} ASCII letters, digits and /._-",
        directory.display()
    );
    Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, reason))
}

/// Has the calling process make its files for its user alone: archives, models, the rig's lock.
pub fn keep_files_private() {
    nix::sys::stat::umask(nix::sys::stat::Mode::from_bits_truncate(0o077));
}

/// Closes what others could open in shared memory under the rig's prefix.
///
/// iceoryx2 makes its segments for the user alone, but one, which counts the rig's nodes, for everyone.
///
/// # Errors
/// Where such a file belongs to another user, who could have made it first.
pub(crate) fn close_shared_memory(prefix: &str) -> std::io::Result<()> {
    for entry in std::fs::read_dir(SHARED_MEMORY)?.flatten() {
        if entry.file_name().to_string_lossy().starts_with(prefix) {
            match close_to_others(&entry.path(), 0o600) {
                // Another process of the rig ended just now and took it away.
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => {}
                closed => closed?,
            }
        }
    }
    Ok(())
}

/// Leaves a file or folder to its owner, who must be the calling process's user.
fn close_to_others(path: &Path, mode: u32) -> std::io::Result<()> {
    use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
    let found = std::fs::metadata(path)?;
    if found.uid() != nix::unistd::geteuid().as_raw() {
        let reason = format!(
            "{} belongs to user {}: remove it, or name another directory in {RUNTIME_DIR_VARIABLE}",
            path.display(),
            found.uid()
        );
        return Err(std::io::Error::new(std::io::ErrorKind::PermissionDenied, reason));
    }
    if found.mode() & 0o077 != 0 {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode))?;
    }
    Ok(())
}

/// The prefix of every shared-memory file of the rig, such as `hc_0123456789abcdef_`.
#[must_use]
pub fn shared_memory_prefix() -> String {
    shared_memory_prefix_of(&runtime_dir())
}

/// The prefix of every shared-memory file of the rig with the given runtime directory.
#[must_use]
pub fn shared_memory_prefix_of(runtime_dir: &Path) -> String {
    format!("hc_{:016x}_", fnv1a(runtime_dir.as_os_str().as_encoded_bytes()))
}

/// FNV-1a, 64 bit: a short name for a long one.
pub(crate) fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
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

/// How long a process's main thread has waited for a processor, all told (`/proc/PID/schedstat`, second field); zero where
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

fn clock_ns(clock: nix::time::ClockId) -> u64 {
    // Both clocks exist on every Linux; a failure cannot happen and would read as time 0.
    clock.now().map_or(0, |time| {
        u64::try_from(time.tv_sec()).unwrap_or(0) * 1_000_000_000 + u64::try_from(time.tv_nsec()).unwrap_or(0)
    })
}
