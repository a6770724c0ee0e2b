//! The kernel's interface for telling one thread of the system calls of another (Linux, *Seccomp BPF*, `seccomp_unotify(2)`).

#![allow(unsafe_code, reason = "seccomp has no safe interface in a crate in use here")]

use std::io;
use std::os::fd::{AsRawFd as _, FromRawFd as _, OwnedFd, RawFd};
use std::time::Duration;

use libc::{
    BPF_ABS, BPF_JEQ, BPF_JMP, BPF_JUMP, BPF_K, BPF_LD, BPF_RET, BPF_STMT, BPF_W, SECCOMP_FILTER_FLAG_NEW_LISTENER,
    SECCOMP_FILTER_FLAG_SPEC_ALLOW, SECCOMP_RET_ALLOW, SECCOMP_RET_USER_NOTIF, SECCOMP_SET_MODE_FILTER,
};

/// Bytes at which `seccomp_data` holds the call's number.
const NUMBER_AT: u32 = 0;
/// Bytes at which `seccomp_data` holds the low halves of the call's first two arguments (little endian).
const FIRST_ARGUMENT_AT: u32 = 16;
const SECOND_ARGUMENT_AT: u32 = 24;

/// Reports every further system call of the calling thread to the returned descriptor, except the loop's own sleep until a time
/// of CLOCK_MONOTONIC, and readings of that clock (which are no calls where the kernel maps it).
///
/// A driver's `sleep`, `usleep` and `nanosleep` last for a duration, and so are reported.
/// From here to its end the thread waits at every other call until somebody answers.
///
/// # Errors
/// The system's, where it does not permit it.
pub(super) fn tell_own_calls() -> io::Result<RawFd> {
    let mut filter = program();
    let program = libc::sock_fprog { len: filter.len() as u16, filter: filter.as_mut_ptr() };
    // SAFETY: the call takes plain numbers; it only takes rights away, from this thread.
    if unsafe { libc::prctl(libc::PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: `program` and the instructions that it points to live beyond the call, which copies them.
    let listener = unsafe {
        libc::syscall(
            libc::SYS_seccomp,
            SECCOMP_SET_MODE_FILTER,
            SECCOMP_FILTER_FLAG_NEW_LISTENER | SECCOMP_FILTER_FLAG_SPEC_ALLOW,
            &raw const program,
        )
    };
    if listener < 0 { Err(io::Error::last_os_error()) } else { Ok(RawFd::try_from(listener).unwrap_or(-1)) }
}

/// The filter that reports all calls but the sleep and the clock.
fn program() -> [libc::sock_filter; 9] {
    let load = |at| {
        // SAFETY: it only puts numbers into a struct.
        unsafe { BPF_STMT((BPF_LD | BPF_W | BPF_ABS) as u16, at) }
    };
    let skip_if = |value, equal, other| {
        // SAFETY: it only puts numbers into a struct.
        unsafe { BPF_JUMP((BPF_JMP | BPF_JEQ | BPF_K) as u16, value, equal, other) }
    };
    let give = |action| {
        // SAFETY: it only puts numbers into a struct.
        unsafe { BPF_STMT((BPF_RET | BPF_K) as u16, action) }
    };
    [
        load(NUMBER_AT),
        skip_if(libc::SYS_clock_nanosleep as u32, 0, 2),
        load(SECOND_ARGUMENT_AT),
        skip_if(libc::TIMER_ABSTIME as u32, 1, 4),
        skip_if(libc::SYS_clock_gettime as u32, 0, 3),
        load(FIRST_ARGUMENT_AT),
        skip_if(libc::CLOCK_MONOTONIC as u32, 0, 1),
        give(SECCOMP_RET_ALLOW),
        give(SECCOMP_RET_USER_NOTIF),
    ]
}

/// A notification of a thread's call.
#[derive(Debug)]
pub(super) struct Listener(OwnedFd);

/// What came.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Heard {
    /// A call with this number is about to be made; the thread waits for [`Listener::let_pass`].
    Call {
        /// The call's number.
        number: i64,
        /// What to answer.
        id: u64,
    },
    /// Nothing so far.
    Nothing,
    /// The thread has ended.
    End,
}

impl Listener {
    /// Takes over what [`tell_own_calls`] gave.
    pub(super) fn new(descriptor: RawFd) -> Self {
        // SAFETY: the descriptor was made by `tell_own_calls`, which hands it out once, to nobody else.
        Self(unsafe { OwnedFd::from_raw_fd(descriptor) })
    }

    /// Waits for a call, for a while.
    pub(super) fn wait(&self, patience: Duration) -> Heard {
        let mut entry = libc::pollfd { fd: self.0.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        let milliseconds = i32::try_from(patience.as_millis()).unwrap_or(i32::MAX);
        // SAFETY: the pointer is to one live entry, as the count says.
        let ready = unsafe { libc::poll(&raw mut entry, 1, milliseconds) };
        if ready <= 0 {
            return Heard::Nothing;
        }
        if entry.revents & libc::POLLIN == 0 {
            return Heard::End;
        }
        // SAFETY: all zeros is a valid value of this struct of plain numbers, and what the kernel asks for.
        let mut call: libc::seccomp_notif = unsafe { std::mem::zeroed() };
        // SAFETY: the kernel fills a live struct of the type that the request is defined with.
        if unsafe { libc::ioctl(self.0.as_raw_fd(), libc::SECCOMP_IOCTL_NOTIF_RECV, &raw mut call) } != 0 {
            return Heard::Nothing;
        }
        Heard::Call { number: i64::from(call.data.nr), id: call.id }
    }

    /// Lets the call be made as if nobody had looked.
    pub(super) fn let_pass(&self, id: u64) {
        let mut answer =
            libc::seccomp_notif_resp { id, val: 0, error: 0, flags: libc::SECCOMP_USER_NOTIF_FLAG_CONTINUE as u32 };
        // SAFETY: the kernel reads a live struct of the type that the request is defined with. A thread that was
        // killed meanwhile needs no answer.
        unsafe { libc::ioctl(self.0.as_raw_fd(), libc::SECCOMP_IOCTL_NOTIF_SEND, &raw mut answer) };
    }
}
