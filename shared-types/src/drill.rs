//! A panic on purpose: what one leaves behind can only be seen by having one.
//!
//! A process of the rig whose environment holds [`DRILL_VARIABLE`] panics when SIGUSR1 comes; without the variable the
//! signal is not listened for and nothing of this exists. Tests and studies of faults use it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Makes the processes of a rig panic at a signal, when it is set.
pub const DRILL_VARIABLE: &str = "HAPTIC_CAMERA_DRILL";
/// The signal for the thread that serves: of a consumer the only one, of the control loop the publisher.
pub const SERVING_THREAD: i32 = signal_hook::consts::SIGUSR1;
/// The signal for the control loop's real-time thread.
pub const REAL_TIME_THREAD: i32 = signal_hook::consts::SIGUSR2;

/// Whether a panic was asked for.
#[derive(Clone, Debug)]
pub struct Drill(Arc<AtomicBool>);

impl Drill {
    /// Listens for `signal`, in a process that was started for a drill; `None` in any other.
    ///
    /// # Errors
    /// The system's, when it does not let the process listen.
    pub fn listen(signal: i32) -> std::io::Result<Option<Self>> {
        if std::env::var_os(DRILL_VARIABLE).is_none() {
            return Ok(None);
        }
        let told = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(signal, Arc::clone(&told))?;
        Ok(Some(Self(told)))
    }

    /// Panics once the signal came.
    ///
    /// # Panics
    /// That is what it is for.
    pub fn panic_if_told(&self) {
        assert!(!self.0.load(Ordering::Relaxed), "a drill: this panic was asked for");
    }
}
