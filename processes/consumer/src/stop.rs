//! When a consumer must stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use shared_types::fault_injection::{self, FaultInjection};
use shared_types::lease::Lease;
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// The process cannot listen for the request to stop.
#[derive(Debug, thiserror::Error)]
#[error("the process cannot listen for the request to stop ({0}); start it again")]
pub struct StopError(#[from] std::io::Error);

/// Knows whether the process is to end.
///
/// Under a supervisor the process ends with its [`Lease`]. When a terminal closes or a machine goes down, every process receives
/// the signals that end it at once; acting on them is left to the supervisor, which ends the run in order.
#[derive(Debug)]
pub struct Stop {
    asked: Arc<AtomicBool>,
    lease: Option<Lease>,
    fault: Option<FaultInjection>,
}

impl Stop {
    /// Begins to listen. Without a supervisor SIGTERM ends the process.
    ///
    /// # Errors
    /// [`StopError`] when the system refuses.
    pub fn listen() -> Result<Self, StopError> {
        let lease = Lease::of_this_process()?;
        let (asked, left_to_supervisor) = (Arc::default(), Arc::default());
        let of_sigterm = if lease.is_some() { &left_to_supervisor } else { &asked };
        signal_hook::flag::register(SIGTERM, Arc::clone(of_sigterm))?;
        for signal in [SIGINT, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&left_to_supervisor))?;
        }
        Ok(Self { asked, lease, fault: FaultInjection::listen(fault_injection::SERVING_THREAD)? })
    }

    /// Begins to listen in a program that the operator has in the foreground: SIGINT and SIGHUP end it too.
    ///
    /// # Errors
    /// [`StopError`] when the system refuses.
    pub fn listen_in_foreground() -> Result<Self, StopError> {
        let stop = Self::listen()?;
        for signal in [SIGINT, SIGHUP] {
            signal_hook::flag::register(signal, Arc::clone(&stop.asked))?;
        }
        Ok(stop)
    }

    /// True once the process is to end.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        if let Some(fault) = &self.fault {
            fault.panic_if_requested();
        }
        self.asked.load(Ordering::Relaxed) || self.lease.as_ref().is_some_and(Lease::has_ended)
    }
}
