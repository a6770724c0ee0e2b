//! The share of the processors that a consumer asks for.

/// Niceness asked for: 9.3 times the weight of an ordinary process (1.25 a step, sched(7)).
const NICENESS: i32 = -10;

/// Puts this process before ordinary ones, so that a machine that compiles or draws does not starve it; `false` where
/// that is not permitted, which costs punctuality alone. Threads that are started later inherit it.
#[allow(unsafe_code, reason = "no safe crate in use here sets a niceness")]
pub fn raise_priority() -> bool {
    // SAFETY: the call takes three numbers and touches no memory of ours.
    unsafe { libc::setpriority(libc::PRIO_PROCESS, 0, NICENESS) == 0 }
}
