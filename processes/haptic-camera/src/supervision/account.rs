//! What became of every tick of a run: taken or missed, dropped or published, in the archive or not.

use std::path::Path;

use archive::{ArchiveError, Capture, Gap, Overview, RigAccount};
use shared_types::{LoopStatus, RunDescription};

const LISTED_GAPS: usize = 5;

/// What lies in the archive of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Archived {
    /// Samples that are there.
    pub(crate) samples: u64,
    /// Samples that the archive itself knows to be missing …
    missing: u64,
    /// … and where, as far as this was read.
    gaps: Vec<Gap>,
    /// How the rig kept up with the ticks …
    rig: RigAccount,
    /// … in a run of this description.
    run: Option<RunDescription>,
}

impl Archived {
    /// Counts what is in an archive, in memory that does not grow with it.
    pub(crate) fn read(archive: &Path) -> Result<Self, ArchiveError> {
        let Overview { samples, lost_samples, rig, description, .. } = Overview::read(archive)?;
        Ok(Self { samples, missing: lost_samples, gaps: Vec::new(), rig, run: description })
    }

    /// How the rig kept up with the ticks, as [`RigAccount::in_words`] says it.
    pub(super) fn rig_in_words(&self, reported: i32) -> Vec<String> {
        self.run.as_ref().map(|run| self.rig.in_words(run, reported)).unwrap_or_default()
    }
}

impl From<&Capture> for Archived {
    fn from(capture: &Capture) -> Self {
        let missing = capture.gaps.iter().map(|gap| gap.count).sum();
        Self {
            samples: capture.len() as u64 + capture.unmeasured_samples,
            missing,
            gaps: capture.gaps.clone(),
            rig: capture.rig.clone(),
            run: capture.description.clone(),
        }
    }
}

/// What is not as it should be after a run, one sentence for each; empty when nothing was lost.
///
/// `is_cut`: the run was ended on purpose, or by a reported fault, so that it may be shorter than planned.
pub(super) fn losses(status: &LoopStatus, archived: &Archived, is_cut: bool) -> Vec<String> {
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
    let known = archived.samples + archived.missing;
    let missing = archived.missing + taken.saturating_sub(known);
    if missing > 0 {
        let listed = &archived.gaps[..archived.gaps.len().min(LISTED_GAPS)];
        let mut places: Vec<String> = listed.iter().map(ToString::to_string).collect();
        if listed.iter().map(|gap| gap.count).sum::<u64>() < archived.missing {
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
    use super::*;

    fn status(published_samples: u64, missed_ticks: u64, dropped_samples: u64) -> LoopStatus {
        LoopStatus { planned_ticks: 1_000, published_samples, missed_ticks, dropped_samples, ..LoopStatus::default() }
    }

    fn archived(samples: u64, gaps: &[(u64, u64)]) -> Archived {
        let gaps: Vec<Gap> = gaps
            .iter()
            .map(|&(first, last)| Gap { first_missing_seq: first, last_missing_seq: last, count: last - first + 1 })
            .collect();
        Archived { samples, missing: gaps.iter().map(|gap| gap.count).sum(), gaps, ..Archived::default() }
    }

    #[test]
    fn samples_and_missed_ticks_that_add_up_to_the_plan_and_lie_in_the_archive_are_all_there_is() {
        assert_eq!(losses(&status(990, 10, 0), &archived(990, &[]), false), Vec::<String>::new());
    }

    #[test]
    fn an_archive_that_ends_before_the_run_is_reported_with_the_samples_after_its_end() {
        let losses = losses(&status(1_000, 0, 0), &archived(300, &[]), false);
        assert_eq!(losses, ["700 of 1000 samples are missing in the archive: samples 300 to 999 (700)"]);
    }

    #[test]
    fn a_run_that_was_cut_short_is_reported_and_one_that_the_operator_ended_is_not() {
        let [cut]: [String; 1] = losses(&status(400, 5, 0), &archived(400, &[]), false).try_into().unwrap_or_default();
        assert!(cut.contains("after 405 of 1000 ticks: ticks 405 to 999 (595)"), "{cut}");
        assert_eq!(losses(&status(400, 5, 0), &archived(400, &[]), true), Vec::<String>::new());
    }

    #[test]
    fn samples_that_were_never_published_are_reported_though_the_archive_has_all_that_were() {
        let losses = losses(&status(800, 0, 200), &archived(800, &[(600, 799)]), false);
        assert_eq!(losses.len(), 2, "{losses:?}");
        assert!(losses[0].contains("200 samples were taken but not published"), "{losses:?}");
        assert_eq!(losses[1], "200 of 1000 samples are missing in the archive: samples 600 to 799 (200)");
    }
}
