//! What the recorder says about itself.

use std::time::{Duration, Instant};

use shared_types::{ProcessHealth, ProcessKind, Sample, rig};

/// How often it is said.
const INTERVAL: Duration = Duration::from_millis(500);

/// Counts for the health report.
#[derive(Debug)]
pub(crate) struct Health {
    restarts: u32,
    received_samples: u64,
    latency_ns: u64,
    reported: Option<Instant>,
}

impl Health {
    pub(crate) fn new(restarts: u32) -> Self {
        Self { restarts, received_samples: 0, latency_ns: 0, reported: None }
    }

    /// Takes note of a block that was just taken from the queue.
    pub(crate) fn received(&mut self, block: &[Sample]) {
        self.received_samples += block.len() as u64;
        if let Some(newest) = block.last() {
            self.latency_ns = rig::monotonic_time_ns().saturating_sub(newest.monotonic_time_ns);
        }
    }

    /// The report, when it is time for one.
    pub(crate) fn report(&mut self, lost_samples: u64) -> Option<ProcessHealth> {
        if self.reported.is_some_and(|reported| reported.elapsed() < INTERVAL) {
            return None;
        }
        self.reported = Some(Instant::now());
        Some(ProcessHealth {
            received_samples: self.received_samples,
            lost_samples,
            latency_ns: self.latency_ns,
            ..ProcessHealth::of_this_process(ProcessKind::Recorder, self.restarts)
        })
    }
}
