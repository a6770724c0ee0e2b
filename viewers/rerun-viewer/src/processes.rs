//! How the processes of the run fare.

use shared_types::{LoopState, LoopStatus, ProcessHealth, ProcessKind};

use crate::numbers::{alarmed, grouped};
use crate::run::Run;

/// Age of the newest sample above which a report counts as late, ms.
const LATE_MS: u64 = 100;
/// Silence after which a process no longer counts as alive, s; every one of them reports at least twice a second.
const SILENT_S: f64 = 2.0;

/// A consumer as its last report has it.
#[derive(Clone, Copy, Debug)]
pub struct Process {
    pub kind: ProcessKind,
    pub report: ProcessHealth,
    /// Share of one core since the report before, percent; NaN for the first report of a process.
    cpu_share_percent: f64,
    /// Reports so far whose newest sample was older than [`LATE_MS`].
    late_reports: u64,
}

impl Process {
    /// The quantities that are drawn over time, in the order of [`HEALTH`](crate::entities::HEALTH).
    pub fn quantities(&self) -> [f64; 4] {
        let ProcessHealth { lost_samples, latency_ns, .. } = self.report;
        [self.cpu_share_percent, self.resident_mib(), lost_samples as f64, latency_ns as f64 / 1e6]
    }

    fn resident_mib(&self) -> f64 {
        self.report.resident_bytes as f64 / (1024.0 * 1024.0)
    }
}

/// The consumers that have reported, in the order of their kinds.
#[derive(Clone, Debug, Default)]
pub struct Processes(Vec<Process>);

impl Processes {
    /// Takes in a report; `None` for a process that this version does not know.
    pub fn take_in(&mut self, report: &ProcessHealth) -> Option<&Process> {
        let kind = ProcessKind::from_code(report.process)?;
        let place = self.0.partition_point(|process| process.report.process < report.process);
        let before = self.0.get(place).copied().filter(|process| process.kind == kind);
        // After a restart the CPU time begins anew and cannot be compared.
        let comparable = before.map(|before| before.report).filter(|before| {
            before.process_id == report.process_id && before.monotonic_time_ns < report.monotonic_time_ns
        });
        let cpu_share_percent = comparable.map_or(f64::NAN, |before| {
            let cpu_time_ns = report.cpu_time_ns.saturating_sub(before.cpu_time_ns);
            100.0 * cpu_time_ns as f64 / (report.monotonic_time_ns - before.monotonic_time_ns) as f64
        });
        let late_before = before.map_or(0, |before| before.late_reports);
        let late_reports = late_before + u64::from(report.latency_ns > LATE_MS * 1_000_000);
        let process = Process { kind, report: *report, cpu_share_percent, late_reports };
        self.0.splice(place..place + usize::from(before.is_some()), [process]);
        self.0.get(place)
    }
}

/// One process, the control loop or a consumer, at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    pub name: &'static str,
    /// Whether it is there, in a few words.
    alive: String,
    /// Whether that calls for the operator.
    pub alarm: bool,
    /// Times it was late: for the control loop, stalls that missed ticks; for a consumer, reports with a sample older than [`LATE_MS`].
    late: u64,
    /// Samples that it lost; of the control loop, that its ring lost.
    pub lost: u64,
    /// Times it was restarted during the run.
    restarts: u32,
    /// Share of a core and resident memory, where they are known.
    used: [String; 2],
}

/// The control loop, then the consumers in the order of their kinds, at that CLOCK_MONOTONIC.
pub fn rows(run: &Run, now_ns: u64) -> Vec<Row> {
    let ended = run.status.is_some_and(|status| status.finished != 0);
    let control_loop = run.status.map(|status| control_loop(&status, run.source_gone, now_ns));
    control_loop.into_iter().chain(run.processes.0.iter().map(|process| consumer(process, now_ns, ended))).collect()
}

fn control_loop(status: &LoopStatus, source_gone: bool, now_ns: u64) -> Row {
    let (alive, alarm) = match LoopState::from_code(status.state) {
        _ if source_gone => ("gone".to_owned(), true),
        Some(LoopState::Fault) => ("fault".to_owned(), true),
        _ if status.finished != 0 => ("ended".to_owned(), false),
        _ => alive(status.monotonic_time_ns, now_ns),
    };
    let (late, lost) = (status.overruns, status.dropped_samples);
    Row { name: "rt-loop", alive, alarm, late, lost, restarts: 0, used: Default::default() }
}

fn consumer(process: &Process, now_ns: u64, ended: bool) -> Row {
    let Process { kind, report, cpu_share_percent, late_reports } = process;
    let (alive, alarm) = match alive(report.monotonic_time_ns, now_ns) {
        // A recorder that has closed its archive ends in order.
        (_, true) if ended => ("ended".to_owned(), false),
        alive => alive,
    };
    let cpu = if cpu_share_percent.is_finite() { format!("{cpu_share_percent:.1} %") } else { String::new() };
    let used = [cpu, format!("{:.0} MiB", process.resident_mib())];
    let (late, lost, restarts) = (*late_reports, report.lost_samples, report.restarts);
    Row { name: kind.name(), alive, alarm, late, lost, restarts, used }
}

fn alive(heard_ns: u64, now_ns: u64) -> (String, bool) {
    let silence_s = now_ns.saturating_sub(heard_ns) as f64 / 1e9;
    if silence_s < SILENT_S { ("alive".to_owned(), false) } else { (format!("silent for {silence_s:.0} s"), true) }
}

impl Row {
    /// What is to be known at a glance.
    pub fn in_words(&self) -> String {
        let lost = if self.lost > 0 { format!(", {} lost", grouped(self.lost)) } else { String::new() };
        let restarted = if self.restarts > 0 { format!(", restarted {}×", self.restarts) } else { String::new() };
        format!("{}{lost}{restarted}", self.alive)
    }
}

/// The rows as Markdown, and how many frames the screen was too slow for.
pub fn markdown(run: &Run, now_ns: u64, frames_dropped: u64) -> String {
    let row = |Row { name, alive, alarm, late, lost, restarts, used: [cpu, memory] }| {
        let alive = if alarm { format!("**{}**", alive.to_uppercase()) } else { alive };
        let [late, lost, restarts] = [grouped(late), alarmed(lost), alarmed(u64::from(restarts))];
        format!("| {name} | {alive} | {late} | {lost} | {restarts} | {cpu} | {memory} |\n")
    };
    let rows: String = rows(run, now_ns).into_iter().map(row).collect();
    let dropped = match frames_dropped {
        0 => String::new(),
        dropped => format!("\n{} frames were not shown: the screen is too slow\n", grouped(dropped)),
    };
    format!(
        "| process | | late | lost | restarted | CPU | memory |\n|---|---|---:|---:|---:|---:|---:|\n{rows}\n\
         late: of rt-loop, times it missed ticks; of the others, half seconds at whose end the newest sample was older \
         than {LATE_MS} ms. lost: samples that never arrived.\n{dropped}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW_NS: u64 = 100_000_000_000;

    fn report(process_id: u32, monotonic_time_ns: u64) -> ProcessHealth {
        let process = ProcessKind::Recorder.code();
        ProcessHealth { process, process_id, monotonic_time_ns, ..ProcessHealth::default() }
    }

    #[test]
    fn a_process_that_used_a_tenth_of_a_second_in_half_a_second_has_a_fifth_of_a_core() {
        let mut processes = Processes::default();
        let report = |process_id, time_ms: u64, cpu_time_ms: u64| ProcessHealth {
            cpu_time_ns: cpu_time_ms * 1_000_000,
            resident_bytes: 3 << 20,
            ..report(process_id, time_ms * 1_000_000)
        };
        let mut quantities = |report| processes.take_in(&report).unwrap().quantities();
        assert!(quantities(report(9, 1_000, 50))[0].is_nan());
        assert_eq!(quantities(report(9, 1_500, 150)), [20.0, 3.0, 0.0, 0.0]);
        assert!(quantities(report(10, 2_000, 1))[0].is_nan(), "it is not compared with the dead one");
        assert_eq!(processes.0.len(), 1);
    }

    #[test]
    fn reports_with_an_old_sample_are_counted_as_late() {
        let mut processes = Processes::default();
        for (report_ns, latency_ns) in [(1, 150_000_000), (2, 90_000_000), (3, 2_000_000_000)] {
            processes.take_in(&ProcessHealth { latency_ns, ..report(9, report_ns) });
        }
        assert_eq!(processes.0[0].late_reports, 2);
    }

    /// How a consumer with that last report fares beside a control loop with that status.
    fn fares(report: &ProcessHealth, status: LoopStatus) -> (String, bool) {
        let mut run = Run { status: Some(status), ..Run::default() };
        run.processes.take_in(report);
        let row = rows(&run, NOW_NS).remove(1);
        (row.in_words(), row.alarm)
    }

    #[test]
    fn a_process_that_is_silent_for_two_seconds_is_not_called_alive_unless_the_run_has_ended() {
        let running = LoopStatus::default();
        assert_eq!(fares(&report(9, NOW_NS - 1_000_000_000), running), ("alive".to_owned(), false));
        let silent = report(9, NOW_NS - 3_000_000_000);
        assert_eq!(fares(&silent, running), ("silent for 3 s".to_owned(), true));
        assert_eq!(fares(&silent, LoopStatus { finished: 1, ..running }), ("ended".to_owned(), false));
    }

    #[test]
    fn losses_and_restarts_are_shown() {
        let report = ProcessHealth { lost_samples: 12, restarts: 2, ..report(9, NOW_NS) };
        assert_eq!(fares(&report, LoopStatus::default()).0, "alive, 12 lost, restarted 2×");
    }

    #[test]
    fn a_control_loop_that_died_calls_for_the_operator() {
        let status = LoopStatus { monotonic_time_ns: NOW_NS, ..LoopStatus::default() };
        let run = Run { status: Some(status), source_gone: true, ..Run::default() };
        let row = &rows(&run, NOW_NS)[0];
        assert_eq!((row.in_words().as_str(), row.alarm), ("gone", true));
    }
}
