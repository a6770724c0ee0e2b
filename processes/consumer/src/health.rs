//! The health report of a consumer.

use std::time::{Duration, Instant};

use shared_types::{ProcessHealth, ProcessKind, Sample, rig};

use crate::arrivals::Arrivals;

/// Interval between two reports.
const INTERVAL: Duration = Duration::from_millis(500);

/// Counts for the health report.
#[derive(Debug)]
pub struct Health {
    kind: ProcessKind,
    restarts: u32,
    received_samples: u64,
    latency_ns: u64,
    reported: Option<Instant>,
    arrivals: Option<Arrivals>,
}

impl Health {
    /// The counts of a process of this kind, restarted `restarts` times, that has received nothing yet.
    #[must_use]
    pub fn new(kind: ProcessKind, restarts: u32) -> Self {
        Self { kind, restarts, received_samples: 0, latency_ns: 0, reported: None, arrivals: Arrivals::wanted(kind) }
    }

    /// Takes note of a block that was just taken from the queue.
    pub fn received(&mut self, block: &[Sample]) {
        self.received_samples += block.len() as u64;
        let now_ns = rig::monotonic_time_ns();
        if let Some(newest) = block.last() {
            self.latency_ns = now_ns.saturating_sub(newest.monotonic_time_ns);
        }
        if let Some(arrivals) = &mut self.arrivals {
            arrivals.note(block, now_ns);
        }
    }

    /// The next report; `None` until it is due.
    pub fn report(&mut self, lost_samples: u64) -> Option<ProcessHealth> {
        if self.reported.is_some_and(|reported| reported.elapsed() < INTERVAL) {
            return None;
        }
        self.reported = Some(Instant::now());
        Some(ProcessHealth {
            received_samples: self.received_samples,
            lost_samples,
            latency_ns: self.latency_ns,
            ..ProcessHealth::of_this_process(self.kind, self.restarts)
        })
    }
}
