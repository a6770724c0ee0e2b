//! How a run ended, what became of each of its ticks, and the report to the operator.

use std::path::{Path, PathBuf};

use archive::Overview;
use archive::parts::fallback_dir;
use hal::ApparatusError;
use shared_types::{Fault, LoopStatus, ProcessKind, RunDescription};

use crate::outcome::{Outcome, remark, say};
use crate::until_ci::StopRule;

#[derive(Default)]
pub(crate) struct RunEnd {
    pub(crate) status: LoopStatus,
    /// Exit code of the recorder that closed the archive.
    pub(crate) recorder_exit: Option<i32>,
    pub(crate) restarts: Vec<(ProcessKind, u32)>,
    pub(crate) run: RunDescription,
    /// The ticks from which models were rendered, and the models' names.
    pub(crate) models: Vec<(u64, String)>,
    pub(crate) interrupted: bool,
    /// What became known, if the run was to end once enough is.
    pub(crate) achieved: Option<StopRule>,
    /// Whether the control loop died before the run had ended, or did not end well after it.
    pub(crate) loop_failed: bool,
}

pub(super) fn fault_words(run: &RunDescription, status: &LoopStatus) -> Option<String> {
    let fault = Fault::from_code(status.fault)?;
    let words = run.axis.words(&fault.to_string()).into_owned();
    let explained = |code| ApparatusError::Device(code).reason(&run.device_codes);
    let reason = match (fault, status.device_code.cast_signed()) {
        (Fault::Apparatus, code) if code != 0 => explained(code),
        (Fault::Stale, code) if code != 0 => format!("{words} ({})", explained(code)),
        (Fault::Apparatus | Fault::Watchdog | Fault::Sensor | Fault::Stale | Fault::Jump | Fault::Clock, _) => words,
        _ => return Some(words),
    };
    Some(format!("the rig '{}': {reason}", run.apparatus))
}

/// A run that further work depended on ended in a fault.
#[derive(Debug, thiserror::Error)]
#[error("{run}: ended in a fault: {words}")]
pub(crate) struct EndedInFault {
    pub(super) run: String,
    pub(super) words: String,
    pub(crate) fault: Option<Fault>,
}

impl RunEnd {
    pub(crate) fn tell(&self) {
        let status = &self.status;
        let taken = status.taken_samples();
        if let Some(fault) = fault_words(&self.run, &self.status) {
            remark(format!("the run ended in a fault after {taken} samples: {fault}"));
        } else if self.interrupted {
            say(format!("stopped by the operator after {taken} samples"));
        }
        // The last status of a loop that died is older than its last sample.
        let at_least = if self.loop_failed { "at least " } else { "" };
        say(format!(
            "samples  {at_least}{taken} taken, {} ticks missed in {} stalls, longest lateness {:.3} ms",
            status.missed_ticks,
            status.overruns,
            status.max_lateness_ns as f64 / 1e6
        ));
        for (kind, restarts) in self.restarts.iter().filter(|(_, restarts)| *restarts > 0) {
            say(format!("{} died and was restarted {restarts} times", kind.name()));
        }
    }

    /// Path of the closed archive: `archive`, or a file in the temporary directory if the recorder could not write there. `None`
    /// if the recorder closed none, after a remark on what to do.
    pub(crate) fn left_archive(&self, archive: &Path) -> Option<PathBuf> {
        let elsewhere = fallback_dir(self.status.run_id).join(archive.file_name().unwrap_or_default());
        let is_of_this_run = |path: &&Path| archive::run_id(path).is_ok_and(|run| run == Some(self.status.run_id));
        if let Some(found) = [archive, &elsewhere].into_iter().find(is_of_this_run) {
            return Some(found.to_owned());
        }
        remark(format!(
            "the recorder could not close {}; its parts are there or in the temporary folder: run `haptic-camera recover {0} --out \
             WHOLE.mcap`",
            archive.display()
        ));
        None
    }

    pub(crate) fn outcome_without_archive(&self) -> Outcome {
        if self.recorder_exit == Some(3) { self.outcome(true) } else { Outcome::Failed }
    }

    /// Tells how the rig kept up and which planned, taken or archived samples were lost; gives the outcome of the command that
    /// made the run.
    pub(crate) fn settle(&self, archived: &Overview) -> Outcome {
        let account = archived.rig.in_words(&self.run, self.status.device_code.cast_signed());
        account.iter().for_each(|line| say(format!("rig      {line}")));
        let is_enough_known = self.achieved.as_ref().is_some_and(|achieved| achieved.ended_s.is_some());
        let is_cut =
            self.interrupted || is_enough_known || self.loop_failed || fault_words(&self.run, &self.status).is_some();
        let losses = losses(&self.status, archived, is_cut);
        losses.iter().for_each(remark);
        self.outcome(!losses.is_empty() || self.recorder_exit == Some(3))
    }

    fn outcome(&self, is_data_lost: bool) -> Outcome {
        if self.loop_failed || fault_words(&self.run, &self.status).is_some() {
            Outcome::Failed
        } else if is_data_lost {
            Outcome::DataLost
        } else {
            Outcome::Done
        }
    }
}

const LISTED_GAPS: usize = 5;

/// What is not as it should be after a run, one sentence for each; empty when nothing was lost.
///
/// `is_cut`: the run was ended on purpose, or by a reported fault, so that it may be shorter than planned.
fn losses(status: &LoopStatus, archived: &Overview, is_cut: bool) -> Vec<String> {
    let mut losses = Vec::new();
    let LoopStatus { planned_ticks: planned, missed_ticks, dropped_samples: dropped, .. } = *status;
    let taken = status.taken_samples();
    let come_to = taken + missed_ticks;
    if !is_cut && come_to < planned {
        losses.push(format!(
            "the control loop was terminated from outside after {come_to} of {planned} ticks: ticks {come_to} to {} \
             ({}) were never taken",
            planned - 1,
            planned - come_to
        ));
    }
    if dropped > 0 {
        losses.push(format!(
            "{dropped} samples were taken but not published: the publishing thread had no processor for longer than \
             its ring holds"
        ));
    }
    // The archive knows nothing of what came after its end.
    let known = archived.samples + archived.lost_samples;
    let missing = archived.lost_samples + taken.saturating_sub(known);
    if missing > 0 {
        let listed = &archived.gaps[..archived.gaps.len().min(LISTED_GAPS)];
        let mut places: Vec<String> = listed.iter().map(ToString::to_string).collect();
        if listed.iter().map(|gap| gap.count).sum::<u64>() < archived.lost_samples {
            places.push("...; the archive lists them all".to_owned());
        }
        if taken > known {
            places.push(format!("samples {known} to {} ({})", taken - 1, taken - known));
        }
        losses.push(format!("{missing} of {taken} samples are missing in the archive: {}", places.join(", ")));
    }
    losses
}

#[cfg(test)]
mod tests {
    use archive::Gap;

    use super::*;

    fn status(published_samples: u64, missed_ticks: u64, dropped_samples: u64) -> LoopStatus {
        LoopStatus { planned_ticks: 1_000, published_samples, missed_ticks, dropped_samples, ..LoopStatus::default() }
    }

    #[test]
    fn an_archive_that_ends_before_the_run_is_reported_with_the_samples_after_its_end() {
        let archived = Overview { samples: 300, ..Overview::default() };
        let losses = losses(&status(1_000, 0, 0), &archived, false);
        assert_eq!(losses, ["700 of 1000 samples are missing in the archive: samples 300 to 999 (700)"]);
    }

    #[test]
    fn a_run_that_was_cut_short_is_reported_and_one_that_the_operator_ended_is_not() {
        let archived = Overview { samples: 400, ..Overview::default() };
        let [cut]: [String; 1] = losses(&status(400, 5, 0), &archived, false).try_into().unwrap_or_default();
        assert!(cut.contains("after 405 of 1000 ticks: ticks 405 to 999 (595)"), "{cut}");
        assert_eq!(losses(&status(400, 5, 0), &archived, true), Vec::<String>::new());
    }

    #[test]
    fn samples_that_were_never_published_are_reported_though_the_archive_has_all_that_were() {
        let gaps = vec![Gap { first_missing_seq: 600, last_missing_seq: 799, count: 200 }];
        let archived = Overview { samples: 800, lost_samples: 200, gaps, ..Overview::default() };
        let losses = losses(&status(800, 0, 200), &archived, false);
        assert_eq!(losses.len(), 2, "{losses:?}");
        assert!(losses[0].contains("200 samples were taken but not published"), "{losses:?}");
        assert_eq!(losses[1], "200 of 1000 samples are missing in the archive: samples 600 to 799 (200)");
    }
}
