//! What the operating system grants the loop: a priority, locked memory, a core of its own.

use nix::sched::{CpuSet, sched_getaffinity, sched_setaffinity};
use nix::sys::mman::{MlockAllFlags, mlockall};
use nix::sys::signal::SigSet;
use nix::unistd::Pid;
use shared_types::realtime;

/// SCHED_FIFO priority of the loop: above everything ordinary, below the kernel's own threads.
const PRIORITY: i32 = 80;
/// That of the thread that publishes: above everything ordinary, below the loop and the kernel's interrupt threads, which
/// have 50.
const PUBLISHER_PRIORITY: i32 = 40;

/// The permissions that the calling thread was given.
#[derive(Clone, Copy, Debug)]
pub struct Permission {
    /// Bits of [`realtime`].
    pub granted: u32,
    /// The core the thread runs on.
    pub core: u32,
}

impl Permission {
    /// Asks for all of it on `core`, for the calling thread. What is refused is left out of `granted`.
    #[must_use]
    pub fn acquire(core: usize) -> Self {
        let mut granted = 0;
        let mut set = CpuSet::new();
        if set.set(core).is_ok() && sched_setaffinity(Pid::from_raw(0), &set).is_ok() {
            granted |= realtime::PINNED;
        }
        // Only what is mapped now: of what comes later the loop touches only models, and locking later mappings too would pull the whole of
        // the shared memory into RAM.
        if mlockall(MlockAllFlags::MCL_CURRENT).is_ok() {
            granted |= realtime::LOCKED;
        }
        if set_fifo_priority(PRIORITY) {
            granted |= realtime::FIFO;
        }
        Self { granted, core: u32::try_from(core).unwrap_or(u32::MAX) }
    }

    /// The permissions that were refused, in words; `None` when nothing was.
    #[must_use]
    pub fn refused(&self) -> Option<String> {
        let missing: Vec<&str> = [
            (realtime::FIFO, "a real-time priority (SCHED_FIFO)"),
            (realtime::LOCKED, "locked memory"),
            (realtime::PINNED, "a core of its own"),
        ]
        .iter()
        .filter(|(bit, _)| self.granted & bit == 0)
        .map(|(_, words)| *words)
        .collect();
        (!missing.is_empty()).then(|| missing.join(", "))
    }
}

#[allow(unsafe_code, reason = "no safe crate in use here sets a scheduling policy")]
fn set_fifo_priority(priority: i32) -> bool {
    let parameters = libc::sched_param { sched_priority: priority };
    // SAFETY: the pointer is to a live, initialised sched_param; pid 0 is the calling thread.
    unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameters) == 0 }
}

/// Keeps the processors from idle states that they leave slowly, for as long as it is held.
///
/// The kernel takes the shortest latency that any process asks for through this file (Linux, *PM
/// Quality of Service Interface*); a process that dies lets go of it.
#[derive(Debug)]
pub struct WakefulProcessors {
    _request: std::fs::File,
}

impl WakefulProcessors {
    /// Asks for no idle latency at all; `None` where that is not permitted.
    #[must_use]
    pub fn request() -> Option<Self> {
        let mut file = std::fs::OpenOptions::new().write(true).open("/dev/cpu_dma_latency").ok()?;
        std::io::Write::write_all(&mut file, &0_i32.to_ne_bytes()).ok()?;
        Some(Self { _request: file })
    }
}

/// The last core that the process may run on: the one furthest from where interrupts usually go.
#[must_use]
pub fn last_core() -> usize {
    let Ok(allowed) = sched_getaffinity(Pid::from_raw(0)) else {
        return 0;
    };
    (0..CpuSet::count()).rev().find(|&core| allowed.is_set(core).unwrap_or(false)).unwrap_or(0)
}

/// Keeps the calling thread off `core`, where there is another.
pub fn keep_off_core(core: usize) {
    if let Ok(mut allowed) = sched_getaffinity(Pid::from_raw(0))
        && allowed.unset(core).is_ok()
    {
        // With one core only the set is empty and the call fails: then the core is shared.
        let _ = sched_setaffinity(Pid::from_raw(0), &allowed);
    }
}

/// Keeps the calling thread, and the processes that it starts, off a core for as long as this is held.
#[derive(Debug)]
pub struct OffCore {
    before: Option<CpuSet>,
}

impl OffCore {
    /// Leaves `core`, where there is another.
    #[must_use]
    pub fn leave(core: u32) -> Self {
        let before = sched_getaffinity(Pid::from_raw(0)).ok();
        keep_off_core(usize::try_from(core).unwrap_or(usize::MAX));
        Self { before }
    }
}

impl Drop for OffCore {
    fn drop(&mut self) {
        if let Some(before) = &self.before {
            // What was permitted a moment ago is permitted still.
            let _ = sched_setaffinity(Pid::from_raw(0), before);
        }
    }
}

/// Raises the priority of the calling thread, which publishes, above everything ordinary, so that the ring does not fill up on a
/// machine whose other cores are taken. Where that is not permitted, only the ring's length protects the samples.
pub fn prefer_publisher() {
    let _is_permitted = set_fifo_priority(PUBLISHER_PRIORITY);
}

/// Leaves the process's signals to its other threads: a handler on this one would take its time from a tick.
pub fn block_signals() {
    // Blocking all that can be blocked has no way to fail.
    let _ = SigSet::all().thread_block();
}
