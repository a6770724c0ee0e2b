//! When the recorder is told to stop.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use nix::sys::signal::Signal;
use signal_hook::consts::{SIGINT, SIGTERM};

/// Knows whether SIGTERM came, from the supervisor or because the supervisor died.
#[derive(Debug)]
pub(crate) struct Stop {
    asked: Arc<AtomicBool>,
}

impl Stop {
    /// Begins to listen. SIGINT, which a terminal sends to everyone at once, is left to the
    /// supervisor.
    pub(crate) fn listen() -> anyhow::Result<Self> {
        let asked = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(SIGTERM, Arc::clone(&asked)).context("SIGTERM cannot be listened for")?;
        signal_hook::flag::register(SIGINT, Arc::new(AtomicBool::new(false))).context("SIGINT cannot be ignored")?;
        let parent = nix::unistd::getppid();
        nix::sys::prctl::set_pdeathsig(Signal::SIGTERM).context("the parent's end cannot be watched")?;
        if nix::unistd::getppid() != parent {
            // It died between the two lines above.
            asked.store(true, Ordering::Relaxed);
        }
        Ok(Self { asked })
    }

    /// True once SIGTERM came.
    pub(crate) fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }
}
