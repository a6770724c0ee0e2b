//! Watches that the loop makes no system call but its sleep: off unless asked for, since it changes what a call costs.
//!
//! The kernel tells a thread beside the loop of every call of the loop's thread but the sleep and holds it until it is
//! answered. Between [`CallWatched::begin`] and [`CallWatched::end`] calls are counted; all of them are let pass.
//! A lock shows when it is contended (`futex`), memory when the allocator asks the kernel for it, a log line as `write`.

use std::collections::BTreeMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use hal::RigDescription;

use super::seccomp::{Heard, Listener, tell_own_calls};
use crate::plan::PlanError;

/// Set to 1, has the loop's system calls watched, and the process fail when there was one.
pub const WATCH_CALLS_VARIABLE: &str = "HAPTIC_CAMERA_WATCH_CALLS";

/// How long the watching thread waits at once.
const PATIENCE: Duration = Duration::from_millis(1);

/// Why the loop's system calls are not known, or which of them are not permitted.
#[derive(Debug, thiserror::Error)]
pub enum CallWatchError {
    /// The kernel, or what contains this process, does not let calls be watched.
    #[error("system calls cannot be watched here ({0}); this needs Linux 5.5 or newer and permission to use seccomp")]
    Refused(io::Error),
    /// The thread was to be watched and never said that it began.
    #[error("the real-time thread ended before its system calls were watched")]
    NeverBegun,
    /// The rig made more calls than it declares.
    #[error(
        "the rig made {most} system calls in one tick, but its file permits {permitted}; correct [calls] per_tick, or the driver"
    )]
    TooMany {
        /// Most in one tick.
        most: u32,
        /// Those permitted.
        permitted: u32,
    },
    /// The loop made calls.
    #[error("the real-time thread made system calls besides its sleep: {0}")]
    CallsMade(String),
}

/// The calls that a rig declares.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PermittedCalls {
    numbers: Vec<i64>,
    per_tick: u32,
}

/// The declared calls that a run made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DeclaredCallsMade {
    /// All calls.
    pub total: u64,
    /// Most in one tick.
    pub most_in_a_tick: u32,
}

/// The calls that a rig declares, by number.
///
/// # Errors
/// [`PlanError::UnknownCall`] for a name that is not known here.
pub fn call_numbers(rig: &RigDescription) -> Result<PermittedCalls, PlanError> {
    let number = |name: &String| {
        let found = KNOWN_CALLS.iter().find(|(_, known)| name_of(known) == name);
        found.map(|(number, _)| *number).ok_or_else(|| PlanError::UnknownCall {
            rig: rig.name.clone(),
            call: name.clone(),
            known: KNOWN_CALLS.iter().map(|(_, known)| name_of(known)).collect::<Vec<_>>().join(", "),
        })
    };
    let numbers = rig.calls.names.iter().map(number).collect::<Result<_, _>>()?;
    Ok(PermittedCalls { numbers, per_tick: rig.calls.per_tick })
}

/// What the two threads share.
#[derive(Debug, Default)]
struct Shared {
    /// The listener's descriptor plus one, a negated error number, or 0 before either.
    opened: AtomicI32,
    counting: AtomicBool,
    /// The tick that the watched thread serves.
    tick: AtomicU64,
    over: AtomicBool,
}

/// The side of the watched thread, which says when its calls count.
#[derive(Debug)]
pub struct CallWatched(Arc<Shared>);

impl CallWatched {
    /// From now on the calling thread's calls are counted.
    pub fn begin(&self) {
        match tell_own_calls() {
            // No call may come between: nobody listens before this is stored.
            Ok(descriptor) => self.0.opened.store(descriptor + 1, Ordering::Release),
            Err(error) => self.0.opened.store(-error.raw_os_error().unwrap_or(libc::EINVAL), Ordering::Release),
        }
        self.0.counting.store(true, Ordering::Release);
    }

    /// The calls from now on are those of this tick.
    pub fn tick(&self, number: u64) {
        self.0.tick.store(number, Ordering::Release);
    }

    /// From now on the thread's calls are not counted.
    pub fn end(&self) {
        self.0.counting.store(false, Ordering::Release);
    }
}

/// The side of the watching thread, which counts the calls.
#[derive(Debug)]
pub struct CallWatch {
    shared: Arc<Shared>,
    thread: JoinHandle<Result<Counted, CallWatchError>>,
}

/// Calls that were counted.
#[derive(Debug, Default)]
struct Counted {
    others: BTreeMap<i64, u64>,
    declared: DeclaredCallsMade,
    /// The tick of the last declared call, and how many it has had.
    tick: (u64, u32),
    permitted: PermittedCalls,
}

impl Counted {
    fn count(&mut self, number: i64, tick: u64) {
        if !self.permitted.numbers.contains(&number) {
            *self.others.entry(number).or_insert(0) += 1;
            return;
        }
        self.tick = if self.tick.0 == tick { (tick, self.tick.1 + 1) } else { (tick, 1) };
        self.declared.total += 1;
        self.declared.most_in_a_tick = self.declared.most_in_a_tick.max(self.tick.1);
    }
}

impl CallWatch {
    /// Starts the watching thread; the other end goes to the thread that is to be watched.
    ///
    /// # Errors
    /// The system's, when there can be no further thread.
    pub fn start(permitted: PermittedCalls) -> io::Result<(Self, CallWatched)> {
        let shared = Arc::new(Shared::default());
        let watching = Arc::clone(&shared);
        let thread =
            std::thread::Builder::new().name("call-watch".to_owned()).spawn(move || watch(&watching, permitted))?;
        Ok((Self { shared: Arc::clone(&shared), thread }, CallWatched(shared)))
    }

    /// Waits until the watched thread has ended. `Ok` if all its system calls are declared by the rig, and no tick had more of them
    /// than declared.
    ///
    /// # Errors
    /// [`CallWatchError`]: the calls that it made, or why that is not known.
    pub fn finish(self) -> Result<DeclaredCallsMade, CallWatchError> {
        self.shared.over.store(true, Ordering::Release);
        let Counted { others: counts, declared, permitted, .. } =
            self.thread.join().map_err(|_| CallWatchError::NeverBegun)??;
        if declared.most_in_a_tick > permitted.per_tick {
            return Err(CallWatchError::TooMany { most: declared.most_in_a_tick, permitted: permitted.per_tick });
        }
        if counts.is_empty() {
            return Ok(declared);
        }
        let calls: Vec<String> =
            counts.iter().map(|(&number, count)| format!("{} ({count} times)", call_name(number))).collect();
        Err(CallWatchError::CallsMade(calls.join(", ")))
    }
}

/// Counts calls by number until the watched thread has ended.
fn watch(shared: &Shared, permitted: PermittedCalls) -> Result<Counted, CallWatchError> {
    let listener = loop {
        match shared.opened.load(Ordering::Acquire) {
            0 if shared.over.load(Ordering::Acquire) => return Err(CallWatchError::NeverBegun),
            0 => std::thread::sleep(PATIENCE),
            error if error < 0 => return Err(CallWatchError::Refused(io::Error::from_raw_os_error(-error))),
            opened => break Listener::new(opened - 1),
        }
    };
    let mut counts = Counted { permitted, ..Counted::default() };
    loop {
        match listener.wait(PATIENCE) {
            Heard::Call { number, id } => {
                if shared.counting.load(Ordering::Acquire) {
                    counts.count(number, shared.tick.load(Ordering::Acquire));
                }
                listener.let_pass(id);
            }
            Heard::Nothing if shared.over.load(Ordering::Acquire) => return Ok(counts),
            Heard::Nothing => {}
            Heard::End => return Ok(counts),
        }
    }
}

/// The names of the calls that are likeliest to slip in.
static KNOWN_CALLS: &[(i64, &str)] = &[
    (libc::SYS_futex, "futex, a contended lock or a wake-up"),
    (libc::SYS_write, "write"),
    (libc::SYS_read, "read"),
    (libc::SYS_mmap, "mmap, memory from the kernel"),
    (libc::SYS_munmap, "munmap, memory to the kernel"),
    (libc::SYS_brk, "brk, memory from the kernel"),
    (libc::SYS_madvise, "madvise"),
    (libc::SYS_mprotect, "mprotect"),
    (libc::SYS_clock_gettime, "clock_gettime of another clock"),
    (libc::SYS_sched_yield, "sched_yield"),
    (libc::SYS_ioctl, "ioctl"),
    (libc::SYS_openat, "openat"),
    (libc::SYS_close, "close"),
    (libc::SYS_getpid, "getpid"),
    (libc::SYS_gettid, "gettid"),
    (libc::SYS_getrandom, "getrandom"),
    (libc::SYS_rt_sigreturn, "rt_sigreturn, the end of a signal handler"),
    (libc::SYS_sendto, "sendto"),
    (libc::SYS_recvfrom, "recvfrom"),
    (libc::SYS_sendmsg, "sendmsg"),
    (libc::SYS_recvmsg, "recvmsg"),
    #[cfg(target_arch = "x86_64")]
    (libc::SYS_poll, "poll"),
    (libc::SYS_ppoll, "ppoll"),
    (libc::SYS_readv, "readv"),
    (libc::SYS_writev, "writev"),
    (libc::SYS_pread64, "pread64"),
    (libc::SYS_pwrite64, "pwrite64"),
    (libc::SYS_nanosleep, "nanosleep"),
    (libc::SYS_clock_nanosleep, "clock_nanosleep, a sleep besides the loop's"),
];

/// The call's own name, without the remark behind it.
fn name_of(known: &str) -> &str {
    known.split([',', ' ']).next().unwrap_or_default()
}

fn call_name(number: i64) -> String {
    let found = KNOWN_CALLS.iter().find(|(known, _)| *known == number);
    found.map_or_else(|| format!("number {number}"), |(_, name)| (*name).to_owned())
}
