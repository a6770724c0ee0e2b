//! Work that Ctrl-C ends.

use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread;
use std::time::Duration;

use pyo3::{PyResult, Python};

/// Longest time without a look at Ctrl-C.
pub(crate) const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// Works on a thread of its own, without the interpreter's lock, while this one looks at Ctrl-C, of which Python notifies only its main thread.
///
/// After Ctrl-C the work goes on to its end and its result is dropped: nothing of it is seen by anyone.
pub(crate) fn interruptible<Output: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Output + Send + 'static,
) -> PyResult<Output> {
    let output = py.detach(|| {
        let (sender, receiver) = sync_channel(1);
        let worker = thread::spawn(move || {
            // Nobody listens after Ctrl-C.
            let _ = sender.send(work());
        });
        loop {
            match receiver.recv_timeout(BETWEEN_LOOKS) {
                Ok(output) => return PyResult::Ok(output),
                Err(RecvTimeoutError::Timeout) => Python::attach(|py| py.check_signals())?,
                Err(RecvTimeoutError::Disconnected) => {
                    // A worker that sent nothing panicked.
                    let panic = worker.join().expect_err("the worker sends before it ends");
                    resume_unwind(panic)
                }
            }
        }
    })?;
    // Work that is done before the first look must not put Ctrl-C off, however often it is called.
    py.check_signals()?;
    Ok(output)
}
