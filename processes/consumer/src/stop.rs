//! When a consumer is told to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use nix::sys::signal::Signal;
use shared_types::drill::{self, Drill};
use signal_hook::consts::{SIGINT, SIGTERM};

/// The system does not let the process listen for its end.
#[derive(Debug, thiserror::Error)]
#[error("the process cannot listen for its end ({0}); nothing can be done but to start it again")]
pub struct StopError(#[from] std::io::Error);

/// Knows whether SIGTERM came, from the supervisor or because the supervisor died.
#[derive(Debug)]
pub struct Stop {
    asked: Arc<AtomicBool>,
    drill: Option<Drill>,
}

impl Stop {
    /// Begins to listen. SIGINT, which a terminal sends to everyone at once, is left to the
    /// supervisor.
    ///
    /// # Errors
    /// [`StopError`] when the system refuses.
    pub fn listen() -> Result<Self, StopError> {
        let asked = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(SIGTERM, Arc::clone(&asked))?;
        signal_hook::flag::register(SIGINT, Arc::new(AtomicBool::new(false)))?;
        let parent = nix::unistd::getppid();
        nix::sys::prctl::set_pdeathsig(Signal::SIGTERM).map_err(std::io::Error::from)?;
        if nix::unistd::getppid() != parent {
            // It died between the two lines above.
            asked.store(true, Ordering::Relaxed);
        }
        Ok(Self { asked, drill: Drill::listen(drill::SERVING_THREAD)? })
    }

    /// Begins to listen in a program that the operator has in the foreground: SIGINT ends it too.
    ///
    /// # Errors
    /// [`StopError`] when the system refuses.
    pub fn listen_in_foreground() -> Result<Self, StopError> {
        let stop = Self::listen()?;
        signal_hook::flag::register(SIGINT, Arc::clone(&stop.asked))?;
        Ok(stop)
    }

    /// True once the process was told to end.
    #[must_use]
    pub fn is_asked(&self) -> bool {
        if let Some(drill) = &self.drill {
            drill.panic_if_told();
        }
        self.asked.load(Ordering::Relaxed)
    }
}
