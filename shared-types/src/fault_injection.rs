//! Fault injection: a panic on demand, for tests and studies of what a panic leaves behind.
//!
//! A process of the rig whose environment holds [`FAULT_INJECTION_VARIABLE`] panics on SIGUSR1; without the variable it does
//! not listen for the signal.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Makes the processes of a rig panic at a signal, when it is set.
pub const FAULT_INJECTION_VARIABLE: &str = "HAPTIC_CAMERA_FAULT_INJECTION";
/// The signal for the serving thread: a consumer's only one, the control loop's publisher.
pub const SERVING_THREAD: i32 = signal_hook::consts::SIGUSR1;
/// The signal for the control loop's real-time thread.
pub const REAL_TIME_THREAD: i32 = signal_hook::consts::SIGUSR2;

/// Whether a panic was requested.
#[derive(Clone, Debug)]
pub struct FaultInjection(Arc<AtomicBool>);

impl FaultInjection {
    /// Listens for `signal` if [`FAULT_INJECTION_VARIABLE`] is set; `None` otherwise.
    ///
    /// # Errors
    /// The system's, when it does not let the process listen.
    pub fn listen(signal: i32) -> std::io::Result<Option<Self>> {
        if std::env::var_os(FAULT_INJECTION_VARIABLE).is_none() {
            return Ok(None);
        }
        let requested = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(signal, Arc::clone(&requested))?;
        Ok(Some(Self(requested)))
    }

    /// Panics once the signal came.
    ///
    /// # Panics
    /// That is its purpose.
    pub fn panic_if_requested(&self) {
        assert!(!self.0.load(Ordering::Relaxed), "fault injection: this panic was requested");
    }
}
