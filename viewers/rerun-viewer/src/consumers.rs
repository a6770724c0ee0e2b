//! How the processes fare: from their reports to rates that one can read.

use shared_types::{ProcessHealth, ProcessKind};

/// Age of the newest sample above which a report counts as late, ms.
pub const LATE_MS: f64 = 100.0;

/// One process at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Condition {
    /// Which process.
    pub kind: ProcessKind,
    /// CLOCK_MONOTONIC of the report, ns.
    pub monotonic_time_ns: u64,
    /// Share of one core since the report before, percent; NaN for the first report.
    pub cpu_share_percent: f64,
    /// Resident memory, MiB.
    pub resident_mib: f64,
    /// Samples that never arrived.
    pub lost_samples: u64,
    /// Age of the newest sample when taken, ms.
    pub latency_ms: f64,
    /// Times the process was restarted.
    pub restarts: u32,
    /// Reports so far whose newest sample was older than [`LATE_MS`].
    pub late_reports: u64,
}

/// The processes that have reported, each with its last report.
#[derive(Clone, Debug, Default)]
pub struct Consumers {
    reports: Vec<(ProcessHealth, Condition)>,
}

impl Consumers {
    /// Takes in a report; `None` for a process that this version does not know.
    pub fn take_in(&mut self, health: &ProcessHealth) -> Option<Condition> {
        let kind = ProcessKind::from_code(health.process)?;
        let before = self.reports.iter().position(|(_, condition)| condition.kind == kind);
        let previous = before.map(|at| self.reports.swap_remove(at));
        let late_before = previous.as_ref().map_or(0, |(_, condition)| condition.late_reports);
        let mut condition = condition(kind, health, previous.map(|(health, _)| health).as_ref());
        condition.late_reports = late_before + u64::from(condition.latency_ms > LATE_MS);
        self.reports.push((*health, condition));
        self.reports.sort_by_key(|(report, _)| report.process);
        Some(condition)
    }

    /// The last condition of each process.
    pub fn conditions(&self) -> impl Iterator<Item = &Condition> {
        self.reports.iter().map(|(_, condition)| condition)
    }
}

#[allow(clippy::cast_precision_loss, reason = "shown with a few digits")]
fn condition(kind: ProcessKind, health: &ProcessHealth, previous: Option<&ProcessHealth>) -> Condition {
    // After a restart the CPU time begins anew and cannot be compared.
    let cpu_share_percent = previous
        .filter(|previous| previous.process_id == health.process_id)
        .filter(|previous| previous.monotonic_time_ns < health.monotonic_time_ns)
        .map_or(f64::NAN, |previous| {
            let cpu_time_ns = health.cpu_time_ns.saturating_sub(previous.cpu_time_ns);
            100.0 * cpu_time_ns as f64 / (health.monotonic_time_ns - previous.monotonic_time_ns) as f64
        });
    Condition {
        kind,
        monotonic_time_ns: health.monotonic_time_ns,
        cpu_share_percent,
        resident_mib: health.resident_bytes as f64 / (1024.0 * 1024.0),
        lost_samples: health.lost_samples,
        latency_ms: health.latency_ns as f64 / 1e6,
        restarts: health.restarts,
        late_reports: 0,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "test")]
mod tests {
    use super::*;

    fn report(process_id: u32, monotonic_time_ns: u64, cpu_time_ns: u64) -> ProcessHealth {
        ProcessHealth {
            process: ProcessKind::Recorder.code(),
            process_id,
            monotonic_time_ns,
            cpu_time_ns,
            resident_bytes: 3 << 20,
            ..ProcessHealth::default()
        }
    }

    #[test]
    fn a_process_that_used_a_tenth_of_a_second_in_half_a_second_has_a_fifth_of_a_core() {
        let mut consumers = Consumers::default();
        assert!(consumers.take_in(&report(9, 1_000_000_000, 50_000_000)).unwrap().cpu_share_percent.is_nan());
        let condition = consumers.take_in(&report(9, 1_500_000_000, 150_000_000)).unwrap();
        assert_eq!((condition.cpu_share_percent, condition.resident_mib), (20.0, 3.0));
        assert_eq!(consumers.conditions().count(), 1);
    }

    #[test]
    fn reports_with_an_old_sample_are_counted_as_late() {
        let mut consumers = Consumers::default();
        for (report_ns, latency_ns) in [(1, 150_000_000), (2, 90_000_000), (3, 2_000_000_000)] {
            consumers.take_in(&ProcessHealth { latency_ns, ..report(9, report_ns, 0) });
        }
        assert_eq!(consumers.conditions().next().unwrap().late_reports, 2);
    }

    #[test]
    fn a_restarted_process_is_not_compared_with_the_dead_one() {
        let mut consumers = Consumers::default();
        consumers.take_in(&report(9, 1_000_000_000, 50_000_000));
        assert!(consumers.take_in(&report(10, 1_500_000_000, 1_000)).unwrap().cpu_share_percent.is_nan());
    }
}
