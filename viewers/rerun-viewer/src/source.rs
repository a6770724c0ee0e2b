//! Where samples, fits and health come from.

use dynamics::Axis;
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample};

use crate::model_torque::KnobModel;

/// What is drawn of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Time in the run, ns.
    pub time_ns: i64,
    /// Encoder angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s; NaN where there is none.
    pub velocity_rad_s: f64,
    /// Accelerometer as read, rad/s²; NaN where there is none.
    pub acceleration_rad_s2: f64,
    /// Torque sensor as read, mNm.
    pub torque_mnm: f64,
    /// Whether the contact was closed: 1, or 0; NaN where none is watched.
    pub contact: f64,
    /// Whether the knob turned towards positive angle.
    pub turning_positive: bool,
    /// Whether the knob sticks, where it says so itself, as a rendered one does.
    pub stuck: Option<bool>,
}

/// The torque that the fitted model gives at one moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelTorque {
    /// Time in the run, ns.
    pub time_ns: i64,
    /// As the torque sensor would read it, mNm.
    pub torque_mnm: f64,
}

/// Something that a source has to tell.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// What the run is.
    Description(&'a RunDescription),
    /// Whether a capture's axis turns.
    Axis(Axis),
    /// Consecutive samples of a run.
    Samples {
        /// Identity of the run.
        run_id: u64,
        /// In the order of their ticks.
        samples: &'a [Sample],
    },
    /// The control loop's word about itself.
    Status(&'a LoopStatus),
    /// The control loop died before its run had ended.
    SourceGone,
    /// The model fitted so far.
    Fit(&'a FitUpdate),
    /// The model that a replay renders from some tick on.
    ModelChange(&'a ModelChange),
    /// A consumer's word about itself.
    Health(&'a ProcessHealth),
    /// Consecutive samples of a finished capture.
    Readings(&'a [Reading]),
    /// The model fitted to a finished capture.
    Model {
        /// For the curves over angle and velocity; `None` if no parameter is identified.
        model: Option<&'a KnobModel>,
        /// In the order of time.
        torque: &'a [ModelTorque],
    },
    /// The text next to the plots of a finished capture, as Markdown.
    Text(&'a str),
    /// All of a finished capture has been sent.
    End,
}

/// Gives events as they come, from a running rig or from what one left behind.
pub trait Source {
    /// Hands over everything that has come since the last call; does not wait.
    ///
    /// `samples_wanted` is false while the rate is unknown: samples without a time cannot be
    /// drawn and wait in the source.
    ///
    /// # Errors
    /// When the source has failed for good.
    fn poll(&mut self, samples_wanted: bool, take_in: &mut dyn FnMut(Event<'_>)) -> anyhow::Result<()>;

    /// Whether nothing is lost by asking later: a file waits for a slow screen, a rig does not.
    fn can_wait(&self) -> bool;
}
