//! How a run ended, and the report to the operator.

use std::path::{Path, PathBuf};

use archive::parts::fallback_dir;
use dynamics::Axis;
use hal::ApparatusError;
use shared_types::{Fault, LoopStatus, ProcessKind};

use super::account::{self, Archived};
use crate::outcome::{Outcome, remark, say};
use crate::until_ci::StopRule;

pub(crate) struct RunEnd {
    pub(crate) status: LoopStatus,
    /// Exit code of the recorder that closed the archive.
    pub(crate) recorder_exit: Option<i32>,
    /// Restarts of recorder, live fitter and viewer.
    pub(crate) restarts: Vec<(ProcessKind, u32)>,
    /// What the rig's own codes mean, and its name.
    pub(crate) rig: RigWords,
    /// The models that were rendered, in the order in which they began to be felt.
    pub(crate) models: Vec<ModelStart>,
    pub(crate) interrupted: bool,
    /// What became known, if the run was to end once enough is.
    pub(crate) achieved: Option<StopRule>,
    /// Whether the control loop died before the run had ended, or did not end well after it.
    pub(crate) loop_failed: bool,
}

/// What a run's description says of its rig.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct RigWords {
    pub(crate) name: String,
    /// Whether it turns.
    pub(crate) axis: Axis,
    /// What its own codes mean.
    pub(crate) codes: Vec<(i32, String)>,
}

impl RigWords {
    /// The fault of a loop that drives it, in words.
    pub(crate) fn fault_words(&self, status: &LoopStatus) -> Option<String> {
        let fault = Fault::from_code(status.fault)?;
        let reason = match (fault, status.device_code.cast_signed()) {
            (Fault::Apparatus, code) if code != 0 => ApparatusError::Device(code).reason(&self.codes),
            (Fault::Apparatus | Fault::Sensor | Fault::Stale | Fault::Jump | Fault::Clock, _) => {
                self.axis.words(&fault.to_string()).into_owned()
            }
            _ => return Some(self.axis.words(&fault.to_string()).into_owned()),
        };
        Some(format!("the rig '{}': {reason}", self.name))
    }
}

/// A run on which further work was to rest ended in a fault.
#[derive(Debug, thiserror::Error)]
#[error("{run}: ended in a fault: {words}")]
pub(crate) struct EndedInFault {
    pub(super) run: String,
    pub(super) words: String,
    pub(crate) fault: Option<Fault>,
}

/// A model and the tick from which it was rendered.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct ModelStart {
    pub(crate) tick: u64,
    pub(crate) name: String,
}

impl RunEnd {
    pub(crate) fn tell(&self) {
        let status = &self.status;
        let taken = status.taken_samples();
        if let Some(fault) = self.fault_words() {
            remark(format!("the run ended in a fault after {taken} samples: {fault}"));
        } else if self.interrupted {
            say(format!("stopped by the operator after {taken} samples"));
        }
        // Of a loop that died, the last status is older than its last sample.
        let at_least = if self.loop_failed { "at least " } else { "" };
        say(format!(
            "samples  {at_least}{taken} taken, {} ticks missed in {} stalls, longest lateness {:.3} ms",
            status.missed_ticks,
            status.overruns,
            ns_to_ms(status.max_lateness_ns)
        ));
        for (kind, restarts) in self.restarts.iter().filter(|(_, restarts)| *restarts > 0) {
            say(format!("{} died and was restarted {restarts} times", kind.name()));
        }
    }

    /// Where the recorder closed the archive: in its place, or in the temporary directory when that place failed it.
    /// Tells what to do where it did not.
    pub(crate) fn left_archive(&self, archive: &Path) -> Option<PathBuf> {
        let elsewhere = fallback_dir(self.status.run_id).join(archive.file_name().unwrap_or_default());
        let is_of_this_run = |path: &&Path| archive::run_id(path).is_ok_and(|run| run == Some(self.status.run_id));
        if let Some(found) = [archive, &elsewhere].into_iter().find(is_of_this_run) {
            return Some(found.to_owned());
        }
        remark(format!(
            "the recorder could not close {}; its parts are in the same folder: run `haptic-camera recover {0} --out \
             WHOLE.mcap`",
            archive.display()
        ));
        None
    }

    /// How the command that made the run ended where the recorder could not close the archive.
    pub(crate) fn outcome_without_archive(&self) -> Outcome {
        if self.recorder_exit == Some(3) { self.outcome(true) } else { Outcome::Failed }
    }

    /// Tells how the rig kept up, and what was lost of the run, planned, taken or archived; how the command that made it ended.
    pub(crate) fn settle(&self, archived: &Archived) -> Outcome {
        let account = archived.rig_in_words(self.status.device_code.cast_signed());
        account.iter().for_each(|line| say(format!("rig      {line}")));
        let is_cut = self.is_ended_on_purpose() || self.loop_failed || self.fault_words().is_some();
        let losses = account::losses(&self.status, archived, is_cut);
        losses.iter().for_each(remark);
        self.outcome(!losses.is_empty() || self.recorder_exit == Some(3))
    }

    fn is_ended_on_purpose(&self) -> bool {
        self.interrupted || self.achieved.as_ref().is_some_and(|achieved| achieved.ended_s.is_some())
    }

    fn outcome(&self, is_data_lost: bool) -> Outcome {
        if self.loop_failed || self.fault_words().is_some() {
            Outcome::Failed
        } else if is_data_lost {
            Outcome::DataLost
        } else {
            Outcome::Done
        }
    }

    /// The fault that ended the run, in words.
    pub(crate) fn fault_words(&self) -> Option<String> {
        self.rig.fault_words(&self.status)
    }
}

fn ns_to_ms(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e6
}
