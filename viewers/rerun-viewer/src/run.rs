//! What is known of the run that is shown.

use dynamics::{Axis, Calibration, ParameterKind};
use shared_types::{Estimate, FitUpdate, LoopStatus, RunDescription};

use crate::entities;
use crate::knob_track::Motion;
use crate::processes::Processes;
use crate::rendered::RenderedModel;
use crate::source::Reading;

/// A run, or a finished capture; every text is made of this.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// Identity; `None` before a run is known.
    pub id: Option<u64>,
    pub axis: Option<Axis>,
    pub description: Option<RunDescription>,
    /// Of the rig; without one the model's torque is drawn as if the rig were ideal.
    pub calibration: Option<Calibration>,
    pub status: Option<LoopStatus>,
    /// Whether the control loop died before its run had ended.
    pub source_gone: bool,
    pub fit: Option<FitUpdate>,
    pub rendered: Option<RenderedModel>,
    pub processes: Processes,
    pub newest: Option<Reading>,
    pub motion: Option<Motion>,
    /// Whether all of a finished capture was taken in.
    pub capture_ended: bool,
}

impl Run {
    /// The sample rate, once the run or the loop has published it, Hz.
    pub fn rate_hz(&self) -> Option<f64> {
        let described = self.description.as_ref().map(|description| description.rate_hz);
        described.or(self.status.map(|status| status.rate_hz)).filter(|rate_hz| *rate_hz > 0.0)
    }

    /// The parameters of the fitted model with their estimates; empty before the first fit.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static ParameterKind, Estimate)> {
        let estimates = self.fit.into_iter().flat_map(|fit| fit.estimates()).map(|(_, estimate)| estimate);
        entities::parameters().zip(estimates).filter(|(_, estimate)| estimate.is_in_model())
    }

    /// Whether the run has ended and all of it was taken in.
    pub fn finished(&self) -> bool {
        self.capture_ended || self.status.is_some_and(|status| status.finished != 0)
    }

    pub fn time_ns(&self) -> i64 {
        self.newest.map_or(0, |newest| newest.time_ns)
    }

    pub fn time_s(&self) -> f64 {
        self.time_ns() as f64 / 1e9
    }

    /// Length of the run, s; `None` where the operator ends it.
    pub fn planned_s(&self) -> Option<f64> {
        let run = self.description.as_ref().filter(|run| run.planned_ticks > 0)?;
        Some(run.planned_ticks as f64 / run.rate_hz)
    }
}
