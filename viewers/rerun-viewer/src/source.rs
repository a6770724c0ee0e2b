//! Where samples, fits and health come from.

use dynamics::Axis;
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample};

use crate::model_torque::KnobModel;

/// What is drawn of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Time in the run, ns.
    pub time_ns: i64,
    /// CLOCK_MONOTONIC, ns; 0 in a finished capture.
    pub monotonic_time_ns: u64,
    /// Encoder angle, rad.
    pub angle_rad: f64,
    /// Velocity, rad/s; NaN where there is none.
    pub velocity_rad_s: f64,
    /// Accelerometer as read, rad/s²; NaN where there is none.
    pub acceleration_rad_s2: f64,
    /// Torque sensor as read, mNm; of a rendered knob what it takes from the hand.
    pub torque_mnm: f64,
    /// Whether the contact was closed: 1, or 0; NaN where none is watched.
    pub contact: f64,
    /// Whether the knob turned towards positive angle.
    pub turning_positive: bool,
    /// Whether the knob sticks, where it says so itself, as a rendered one does.
    pub stuck: Option<bool>,
}

impl Reading {
    /// Of a sample of a run at that rate.
    pub fn of(sample: &Sample, rate_hz: f64, is_rendered: bool) -> Self {
        Self {
            time_ns: nanoseconds(sample.time_s(rate_hz)),
            monotonic_time_ns: sample.monotonic_time_ns,
            angle_rad: sample.angle_rad,
            velocity_rad_s: sample.velocity_rad_s,
            acceleration_rad_s2: sample.acceleration_rad_s2,
            // The sensor reads minus that.
            torque_mnm: if is_rendered { -sample.torque_mnm } else { sample.torque_mnm },
            contact: sample.contact,
            turning_positive: sample.velocity_rad_s > 0.0,
            stuck: is_rendered.then_some(sample.flags & Sample::STUCK != 0),
        }
    }
}

/// A time in a run as the screen has it.
#[allow(clippy::cast_possible_truncation, reason = "a run would have to last 292 years")]
pub fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// Something that a source has to tell.
#[derive(Clone, Copy, Debug)]
pub enum Event<'a> {
    /// What the run is.
    Description(&'a RunDescription),
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
    /// What a finished capture is.
    Capture {
        /// Whether it turns.
        axis: Axis,
        /// The text next to its plots, as Markdown.
        text: &'a str,
    },
    /// Consecutive samples of a finished capture.
    Readings(&'a [Reading]),
    /// All of a finished capture has been sent but the model fitted to it.
    End {
        /// For the curves over angle and velocity; `None` if no parameter is identified.
        model: Option<&'a KnobModel>,
        /// Times in the run, ns, in their order, with the torque that the model gives, as the torque sensor would read it, mNm.
        torque: &'a [(i64, f64)],
    },
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
