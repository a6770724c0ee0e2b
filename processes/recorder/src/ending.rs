//! When a recording has come to its end.

use consumer::{SourceWatch, Stop};
use shared_types::{LoopStatus, rig};

use crate::recording::Recording;

/// How long missing samples are waited for after the run has ended, ns.
const PATIENCE_NS: u64 = 1_000_000_000;
/// How long the last estimates and health reports are waited for after the last sample, ns.
const AFTERMATH_NS: u64 = 200_000_000;
/// How long the run's end is waited for once the recorder is asked to stop, ns. A supervisor that is gone ends the control loop
/// too, whose last samples come within that time.
const FAREWELL_NS: u64 = 3_000_000_000;

/// Watches for the end of a run. Times are CLOCK_MONOTONIC.
#[derive(Debug)]
pub(crate) struct Ending {
    run_id: u64,
    status: Option<LoopStatus>,
    source: SourceWatch,
    /// When the last sample came, or the news that the run has ended, ns.
    news_ns: u64,
    /// When every sample of the run was here, ns.
    complete_ns: Option<u64>,
    /// When the recorder was asked to stop, ns.
    asked_ns: Option<u64>,
}

/// Why a recording ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Cause {
    /// Every sample of the run is here, and the last reports had their time to come.
    Complete,
    /// The run has ended, and nothing more comes.
    Overdue,
    /// The control loop's process is gone.
    SourceGone,
    /// The recorder was asked to stop while the run goes on.
    Asked,
}

impl Ending {
    /// Watches for the end of this run.
    pub(crate) fn of_run(run_id: u64) -> Self {
        Self { run_id, status: None, source: SourceWatch::default(), news_ns: 0, complete_ns: None, asked_ns: None }
    }

    /// Takes note of the control loop's status; false for one of another run.
    pub(crate) fn hear(&mut self, status: &LoopStatus, now_ns: u64) -> bool {
        if status.run_id != self.run_id {
            return false;
        }
        let ended_before = self.status.is_some_and(|before| before.finished == 1);
        if status.finished == 1 && !ended_before {
            self.news_ns = now_ns;
        }
        self.source.hear(status, now_ns);
        self.status = Some(*status);
        true
    }

    /// Takes note that samples came.
    pub(crate) fn hear_samples(&mut self, now_ns: u64) {
        self.news_ns = now_ns;
    }

    /// Samples that the run has taken, as far as the control loop has said.
    pub(crate) fn taken_samples(&self) -> u64 {
        self.status.map_or(0, |status| status.taken_samples())
    }

    /// Whether the recording ends now; warns unless the run is complete.
    pub(crate) fn has_come(&mut self, recording: &Recording, stop: &Stop) -> bool {
        let now_ns = rig::monotonic_time_ns();
        if stop.is_asked() {
            self.asked_ns.get_or_insert(now_ns);
        }
        let cause = self.cause(now_ns, recording.next_seq(), self.source.is_gone(now_ns));
        match cause {
            None | Some(Cause::Complete) => {}
            Some(Cause::Overdue) => tracing::warn!(
                "the run had {} samples, but only the first {} arrived",
                self.taken_samples(),
                recording.next_seq()
            ),
            Some(Cause::Asked) => tracing::warn!("stopped during the run: the archive ends here"),
            Some(Cause::SourceGone) => {
                tracing::warn!("the control loop died before the end of the run: the archive ends here");
            }
        }
        cause.is_some()
    }

    fn cause(&mut self, now_ns: u64, next_seq: u64, source_is_gone: bool) -> Option<Cause> {
        let asked = self.asked_ns.filter(|asked_ns| now_ns.saturating_sub(*asked_ns) > FAREWELL_NS);
        let Some(status) = self.status else { return asked.map(|_| Cause::Asked) };
        if status.finished == 1 {
            if next_seq >= status.taken_samples() {
                let complete_ns = *self.complete_ns.get_or_insert(now_ns);
                return (now_ns.saturating_sub(complete_ns) > AFTERMATH_NS).then_some(Cause::Complete);
            }
            return (now_ns.saturating_sub(self.news_ns) > PATIENCE_NS).then_some(Cause::Overdue);
        }
        if source_is_gone { Some(Cause::SourceGone) } else { asked.map(|_| Cause::Asked) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: u64 = 1_000_000_000;

    fn status(finished: u32, published_samples: u64) -> LoopStatus {
        LoopStatus { run_id: 5, finished, published_samples, process_id: 77, ..LoopStatus::default() }
    }

    #[test]
    fn a_run_is_complete_once_its_last_sample_is_here_and_the_last_reports_had_time() {
        let mut ending = Ending::of_run(5);
        assert!(ending.hear(&status(1, 100), SECOND));
        assert_eq!(ending.cause(SECOND, 99, false), None);
        assert_eq!(ending.cause(2 * SECOND, 100, false), None);
        assert_eq!(ending.cause(2 * SECOND + AFTERMATH_NS + 1, 100, false), Some(Cause::Complete));
    }

    #[test]
    fn a_sample_that_never_comes_is_waited_for_one_second_after_the_last_news() {
        let mut ending = Ending::of_run(5);
        assert!(ending.hear(&status(1, 100), SECOND));
        ending.hear_samples(3 * SECOND);
        assert!(ending.hear(&status(1, 100), 4 * SECOND));
        assert_eq!(ending.cause(4 * SECOND, 99, false), None);
        assert_eq!(ending.cause(4 * SECOND + 1, 99, false), Some(Cause::Overdue));
    }

    #[test]
    fn a_control_loop_that_died_ends_the_recording_unless_the_run_had_ended() {
        let mut ending = Ending::of_run(5);
        assert_eq!(ending.cause(9 * SECOND, 0, true), None, "no loop was heard yet");
        assert!(ending.hear(&status(0, 10), SECOND));
        assert_eq!(ending.cause(2 * SECOND, 10, false), None);
        assert_eq!(ending.cause(2 * SECOND, 10, true), Some(Cause::SourceGone));
    }

    #[test]
    fn one_that_is_asked_to_stop_waits_for_the_end_of_the_run_and_not_for_ever() {
        let mut ending = Ending::of_run(5);
        ending.asked_ns = Some(SECOND);
        assert!(ending.hear(&status(0, 10), SECOND));
        assert_eq!(ending.cause(2 * SECOND, 10, false), None);
        assert_eq!(ending.cause(SECOND + FAREWELL_NS + 1, 10, false), Some(Cause::Asked));
        assert!(ending.hear(&status(1, 20), 2 * SECOND));
        assert_eq!(ending.cause(2 * SECOND, 20, false), None);
        assert_eq!(ending.cause(2 * SECOND + AFTERMATH_NS + 1, 20, false), Some(Cause::Complete));
    }

    #[test]
    fn samples_that_the_loop_dropped_at_the_end_are_waited_for_and_reported() {
        let mut ending = Ending::of_run(5);
        let dropped = LoopStatus { dropped_samples: 30, ..status(1, 70) };
        assert!(ending.hear(&dropped, SECOND));
        assert_eq!(ending.taken_samples(), 100);
        assert_eq!(ending.cause(SECOND + AFTERMATH_NS + 1, 70, false), None);
        assert_eq!(ending.cause(SECOND + PATIENCE_NS + 1, 70, false), Some(Cause::Overdue));
    }

    #[test]
    fn the_status_of_another_run_is_not_heard() {
        let mut ending = Ending::of_run(6);
        assert!(!ending.hear(&status(1, 0), SECOND));
        assert_eq!(ending.cause(9 * SECOND, 0, true), None);
    }
}
