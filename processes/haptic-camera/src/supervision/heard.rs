//! How long a process has been silent.

use std::time::Duration;

use shared_types::rig;

/// When a process was last heard, and how long it had waited for a processor until then.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heard {
    process_id: u32,
    /// CLOCK_MONOTONIC, ns.
    at_ns: u64,
    processor_wait: Duration,
}

impl Heard {
    /// A process that was started, or said something, at this time.
    pub(super) fn of(process_id: u32, at_ns: u64) -> Self {
        Self { process_id, at_ns, processor_wait: rig::processor_wait(process_id) }
    }

    /// Takes note of when it last said something.
    pub(super) fn hear(&mut self, at_ns: u64) {
        if at_ns > self.at_ns {
            *self = Self::of(self.process_id, at_ns);
        }
    }

    /// Silence since. The time for which its main thread waited for a processor does not count: a restart would make it
    /// later still.
    pub(super) fn silence(&self) -> Duration {
        let waited = rig::processor_wait(self.process_id).saturating_sub(self.processor_wait);
        Duration::from_nanos(rig::monotonic_time_ns().saturating_sub(self.at_ns)).saturating_sub(waited)
    }
}
