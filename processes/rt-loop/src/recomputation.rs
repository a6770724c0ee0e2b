//! A recorded rendering fed through the control step again: the same torques, bit for bit, or something is not as it was.

use dynamics::{Calibration, Drive, Excitation, ModelError};
use hal::{Limits, Measurement};
use serde::{Deserialize, Serialize};
use shared_types::{DescriptionError, ModelChange, RunDescription};

use crate::control::rendering::{RenderGains, RenderedModel, Renderer, Unrenderable};
use crate::control::{ControlPlan, ControlState, Reading, Request, ServoGains, StepOutput};

/// What the control step was made with besides calibration and model, kept with a run as TOML: there a number keeps all its bits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ControlDescription {
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Ticks of the run.
    pub planned_ticks: u64,
    /// What the rig must not exceed.
    pub limits: Limits,
    /// Ticks after which a torque begins to act, as the compensation of cogging knew them; none in older runs.
    #[serde(default)]
    pub torque_late_ticks: f64,
    /// The same as the passivity guard knew them; none in older runs.
    #[serde(default)]
    pub guard_late_ticks: f64,
    /// Gains of the servo, which also brakes at a stop.
    pub servo_gains: ServoGains,
    /// Gains of the rendering; `None` where a sweep was followed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub render_gains: Option<RenderGains>,
}

/// Why the torques of a run cannot be computed again.
#[derive(Debug, thiserror::Error)]
pub enum NotRecomputable {
    /// No rendering.
    #[error(
        "the capture follows a sweep, whose servo started before the first sample; only a replay can be recomputed"
    )]
    NotRendered,
    /// A run by a program that did not keep what is needed.
    #[error("the archive does not record its gains and limits; replay again with this program")]
    NoControl,
    /// Something in the run's description that cannot be read.
    #[error(transparent)]
    Unreadable(#[from] DescriptionError),
    /// A recorded model that cannot be read.
    #[error(transparent)]
    Malformed(#[from] ModelError),
    /// A model that this program does not render.
    #[error("this program cannot render the recorded model: {0}")]
    Model(#[from] Unrenderable),
    /// A rate at which nothing is rendered.
    #[error("nothing is rendered at {rate_hz} Hz")]
    Rate {
        /// Sample rate, Hz.
        rate_hz: f64,
    },
}

/// A recorded tick of a run.
#[derive(Clone, Copy, Debug)]
pub struct RecordedTick {
    /// What the sensors read.
    pub measurement: Measurement,
    /// Ticks missed directly before it.
    pub missed_ticks: u32,
}

/// The control step at a run's beginning.
pub struct Recomputation {
    control: ControlState,
    calibration: Calibration,
    begun: bool,
}

impl Recomputation {
    /// The control step as it was at the beginning of the run.
    ///
    /// # Errors
    /// [`NotRecomputable`].
    pub fn new(run: &RunDescription) -> Result<Self, NotRecomputable> {
        let first = run.first_model().ok_or(NotRecomputable::NotRendered)?;
        let control_toml = run.control_toml.as_ref().ok_or(NotRecomputable::NoControl)?;
        let described: ControlDescription = run.part("control description", toml::from_str(control_toml))?;
        let calibration = run.calibration()?.ok_or(NotRecomputable::NoControl)?;
        let excitation = run.excitation()?;
        let ControlDescription { rate_hz, planned_ticks, limits, torque_late_ticks, guard_late_ticks, .. } = described;
        let ControlDescription { servo_gains, render_gains, .. } = described;
        let render_gains = render_gains.ok_or(NotRecomputable::NotRendered)?;
        let plan = ControlPlan {
            // Not followed: a model is rendered.
            excitation: Excitation { drive: Drive::Position, ..excitation },
            gains: servo_gains,
            limits,
            rate_hz,
            planned_ticks,
            // What was recorded was within it.
            stale_limit: u32::MAX,
            torque_late_ticks,
        };
        let model = rendered(&first, &calibration)?;
        let too_slow = || NotRecomputable::Rate { rate_hz };
        let motor_mnm = limits.motor_torque_mnm;
        let renderer = Renderer::new(model, render_gains, &calibration, motor_mnm, rate_hz, guard_late_ticks)
            .ok_or_else(too_slow)?;
        let control = ControlState::new(plan, &calibration).ok_or_else(too_slow)?.with_renderer(renderer);
        Ok(Self { control, calibration, begun: false })
    }

    /// Gives the renderer a model that begins to be felt at the next tick; `false` if it does not take it then.
    ///
    /// # Errors
    /// [`NotRecomputable`] for a model that this program cannot read or render.
    pub fn take_model(&mut self, change: &ModelChange) -> Result<bool, NotRecomputable> {
        let model = rendered(change, &self.calibration)?;
        Ok(self.control.take_model(model).is_ok())
    }

    /// The next recorded tick.
    pub fn step(&mut self, tick: &RecordedTick) -> StepOutput {
        let reading = |elapsed_ticks, measurement| Reading { elapsed_ticks, measurement: Ok(measurement) };
        if !self.begun {
            // Armed where the run begins: a rendering follows from its samples alone. A first sample without new data holds the values
            // that were read before it.
            self.control.arm();
            self.control.step(&reading(1, Measurement { is_stale: false, ..tick.measurement }));
            self.control.request(Request::Start);
            self.begun = true;
        }
        let output = self.control.step(&reading(u64::from(tick.missed_ticks) + 1, tick.measurement));
        drop(self.control.retired_model());
        output
    }
}

fn rendered(change: &ModelChange, calibration: &Calibration) -> Result<Box<RenderedModel>, NotRecomputable> {
    Ok(Box::new(RenderedModel::new(&change.model()?, calibration)?))
}
