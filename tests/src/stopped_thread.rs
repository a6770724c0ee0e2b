//! One thread of another process that is kept from running, while the others go on.

use nix::unistd::Pid;

/// Keeps a process's main thread from running for as long as it lives.
///
/// Signals stop whole processes; a tracer can stop one thread.
#[derive(Debug)]
pub struct StoppedThread {
    thread: Pid,
    /// What traces is a thread: this must not go to another.
    _not_send: std::marker::PhantomData<*const ()>,
}

impl StoppedThread {
    /// Stops it; `None` where tracing is not permitted, which is said.
    #[must_use]
    #[allow(clippy::print_stderr, reason = "a test that skips says so")]
    pub fn stop(process: Pid) -> Option<Self> {
        if trace(libc::PTRACE_SEIZE, process) && trace(libc::PTRACE_INTERRUPT, process) {
            return Some(Self { thread: process, _not_send: std::marker::PhantomData });
        }
        eprintln!("SKIPPED: no permission to trace a process");
        None
    }
}

impl Drop for StoppedThread {
    fn drop(&mut self) {
        let _stopped = nix::sys::wait::waitpid(self.thread, Some(nix::sys::wait::WaitPidFlag::__WALL));
        trace(libc::PTRACE_DETACH, self.thread);
    }
}

#[allow(unsafe_code, reason = "a system call that nix has behind a feature which nothing else here needs")]
fn trace(request: libc::c_uint, thread: Pid) -> bool {
    let nothing = std::ptr::null_mut::<libc::c_void>();
    // SAFETY: none of the three requests reads or writes memory of this process.
    unsafe { libc::ptrace(request, thread.as_raw(), nothing, nothing) == 0 }
}
