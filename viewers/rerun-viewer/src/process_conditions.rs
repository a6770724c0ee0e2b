//! Every process of the run in a row: whether it is alive, how often it was late, what it lost, how often it was restarted.

use std::fmt::Write as _;

use shared_types::{LoopState, LoopStatus};

use crate::consumers::{Condition, LATE_MS};
use crate::summary::{Facts, alarmed, grouped};

/// Silence after which a process no longer counts as alive, s; every one of them reports at least twice a second.
const SILENT_S: f64 = 2.0;

/// One process at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its program's name.
    pub name: &'static str,
    /// Whether it is there, in a few words.
    pub alive: String,
    /// Whether that calls for the operator.
    pub alarm: bool,
    /// Times it was late: ticks begun too late for one of them, reports with a sample older than [`LATE_MS`] for the others.
    pub late: u64,
    /// Samples that it lost; of the control loop, that its ring lost.
    pub lost: u64,
    /// Times it was restarted during the run.
    pub restarts: u32,
}

/// The control loop, then the consumers in the order of their kinds.
pub fn rows(facts: &Facts<'_>) -> Vec<Row> {
    let ended = facts.status.is_some_and(|status| status.finished != 0);
    let control_loop = facts.status.map(|status| control_loop(status, facts));
    control_loop.into_iter().chain(facts.consumers.conditions().map(|one| consumer(one, facts.now_ns, ended))).collect()
}

fn control_loop(status: &LoopStatus, facts: &Facts<'_>) -> Row {
    let silence_s = age_s(status.monotonic_time_ns, facts.now_ns);
    let (alive, alarm) = if facts.source_gone {
        ("gone".to_owned(), true)
    } else if LoopState::from_code(status.state) == Some(LoopState::Fault) {
        ("fault".to_owned(), true)
    } else if status.finished != 0 {
        ("ended".to_owned(), false)
    } else {
        alive(silence_s)
    };
    Row { name: "rt-loop", alive, alarm, late: status.overruns, lost: status.dropped_samples, restarts: 0 }
}

fn consumer(condition: &Condition, now_ns: u64, ended: bool) -> Row {
    let (alive, alarm) = match alive(age_s(condition.monotonic_time_ns, now_ns)) {
        // A recorder that has closed its archive ends in order.
        (_, true) if ended => ("ended".to_owned(), false),
        alive => alive,
    };
    let Condition { kind, late_reports, lost_samples, restarts, .. } = *condition;
    Row { name: kind.name(), alive, alarm, late: late_reports, lost: lost_samples, restarts }
}

fn alive(silence_s: f64) -> (String, bool) {
    if silence_s < SILENT_S { ("alive".to_owned(), false) } else { (format!("silent for {silence_s:.0} s"), true) }
}

#[allow(clippy::cast_precision_loss, reason = "seconds with few digits")]
fn age_s(then_ns: u64, now_ns: u64) -> f64 {
    now_ns.saturating_sub(then_ns) as f64 / 1e9
}

impl Row {
    /// What is to be known at a glance.
    pub fn in_words(&self) -> String {
        let mut words = self.alive.clone();
        if self.lost > 0 {
            let _ = write!(words, ", {} lost", grouped(self.lost));
        }
        if self.restarts > 0 {
            let _ = write!(words, ", restarted {}×", self.restarts);
        }
        words
    }
}

/// The rows as Markdown.
pub fn markdown(facts: &Facts<'_>) -> String {
    let mut text =
        "| process | | late | lost | restarted | CPU | memory |\n|---|---|---:|---:|---:|---:|---:|\n".to_owned();
    for row in rows(facts) {
        let condition = facts.consumers.conditions().find(|condition| condition.kind.name() == row.name);
        let cpu = condition.map(|condition| condition.cpu_share_percent).filter(|share| share.is_finite());
        let cpu = cpu.map_or_else(String::new, |share| format!("{share:.1} %"));
        let memory = condition.map_or_else(String::new, |condition| format!("{:.0} MiB", condition.resident_mib));
        let Row { name, alive, alarm, late, lost, restarts } = row;
        let alive = if alarm { format!("**{}**", alive.to_uppercase()) } else { alive };
        let _ = writeln!(
            text,
            "| {name} | {alive} | {} | {} | {} | {cpu} | {memory} |",
            grouped(late),
            alarmed(lost),
            alarmed(u64::from(restarts)),
        );
    }
    let _ = writeln!(
        text,
        "\nlate: of rt-loop, times it missed ticks; of the others, half seconds at whose end the newest sample was older \
         than {LATE_MS:.0} ms. lost: samples that never arrived."
    );
    if facts.frames_dropped > 0 {
        let _ = writeln!(text, "\n{} frames were not shown: the screen is too slow", grouped(facts.frames_dropped));
    }
    text
}

#[cfg(test)]
mod tests {
    use shared_types::{ProcessHealth, ProcessKind};

    use super::*;
    use crate::consumers::Consumers;

    const NOW_NS: u64 = 100_000_000_000;

    fn consumers(monotonic_time_ns: u64, lost_samples: u64, restarts: u32) -> Consumers {
        let mut consumers = Consumers::default();
        let process = ProcessKind::Recorder.code();
        consumers.take_in(&ProcessHealth {
            process,
            monotonic_time_ns,
            lost_samples,
            restarts,
            ..ProcessHealth::default()
        });
        consumers
    }

    fn row_of(consumers: &Consumers, status: LoopStatus) -> Row {
        let facts = Facts { status: Some(&status), now_ns: NOW_NS, ..Facts::nothing(consumers) };
        rows(&facts).remove(1)
    }

    #[test]
    fn a_process_that_is_silent_for_two_seconds_is_not_called_alive() {
        assert_eq!(row_of(&consumers(NOW_NS - 1_000_000_000, 0, 0), LoopStatus::default()).in_words(), "alive");
        let silent = row_of(&consumers(NOW_NS - 3_000_000_000, 0, 0), LoopStatus::default());
        assert_eq!((silent.in_words().as_str(), silent.alarm), ("silent for 3 s", true));
    }

    #[test]
    fn losses_and_restarts_are_shown() {
        let row = row_of(&consumers(NOW_NS, 12, 2), LoopStatus::default());
        assert_eq!(row.in_words(), "alive, 12 lost, restarted 2×");
    }

    #[test]
    fn after_the_run_silence_is_no_alarm() {
        let ended = LoopStatus { finished: 1, ..LoopStatus::default() };
        let row = row_of(&consumers(NOW_NS - 9_000_000_000, 0, 0), ended);
        assert_eq!((row.alive.as_str(), row.alarm), ("ended", false));
    }

    #[test]
    fn a_control_loop_that_died_calls_for_the_operator() {
        let consumers = Consumers::default();
        let status = LoopStatus { monotonic_time_ns: NOW_NS, ..LoopStatus::default() };
        let facts = Facts { status: Some(&status), source_gone: true, now_ns: NOW_NS, ..Facts::nothing(&consumers) };
        assert_eq!((rows(&facts)[0].alive.as_str(), rows(&facts)[0].alarm), ("gone", true));
    }
}
