//! The operator's wish to end: Ctrl-C, SIGTERM, and the terminal's end.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
use signal_hook::flag;

/// Exit status of a command that was ended while its rig rested.
const STOPPED: i32 = 1;

/// Ends this program at once while the rig rests, and a run in order.
pub(crate) struct Interrupt {
    noted: Arc<AtomicBool>,
    at_rest: Arc<AtomicBool>,
}

impl Interrupt {
    pub(crate) fn listen() -> anyhow::Result<Self> {
        let (noted, at_rest) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(true)));
        // A program started by `nohup` ignores SIGHUP, to outlive its terminal.
        let hang_up = (!is_ignored(SIGHUP)).then_some(SIGHUP);
        for signal in [SIGINT, SIGTERM].into_iter().chain(hang_up) {
            flag::register_conditional_shutdown(signal, STOPPED, Arc::clone(&at_rest))?;
            flag::register(signal, Arc::clone(&noted))?;
        }
        Ok(Self { noted, at_rest })
    }

    pub(crate) fn is_noted(&self) -> bool {
        self.noted.load(Ordering::Acquire)
    }

    /// Calls `run`, which must end in order once its flag is set.
    pub(crate) fn noted_during<T>(&self, run: impl FnOnce(&AtomicBool) -> T) -> T {
        self.at_rest.store(false, Ordering::Release);
        let end = run(&self.noted);
        self.at_rest.store(true, Ordering::Release);
        end
    }
}

/// Whether whoever started this program has it ignore a signal (proc(5)).
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
