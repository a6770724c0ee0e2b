//! Where a rig's lock and shared memory live, and the clocks that its processes share.
//!
//! A rig is named by its runtime directory, `$HAPTIC_CAMERA_RUNTIME_DIR`, or else a folder of the
//! user's own under `$XDG_RUNTIME_DIR` or the temporary directory. Everything of iceoryx2's that
//! belongs to the rig carries a prefix made from that path: two rigs never meet, and what one
//! leaves behind can be found.

use std::path::{Path, PathBuf};

/// Names the directory that stands for the rig.
pub const RUNTIME_DIR_VARIABLE: &str = "HAPTIC_CAMERA_RUNTIME_DIR";

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

/// Creates the runtime directory, open to the user alone.
///
/// # Errors
/// The system's, when it cannot be created.
pub fn create_runtime_dir() -> std::io::Result<PathBuf> {
    use std::os::unix::fs::DirBuilderExt as _;
    let directory = runtime_dir();
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(&directory)?;
    Ok(directory)
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
