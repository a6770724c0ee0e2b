//! Where samples, fits and health come from.

use shared_types::Sample;

use crate::picture::Picture;

/// What is drawn of one sample.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Time in the run, ns.
    pub time_ns: i64,
    /// CLOCK_MONOTONIC, ns; 0 in a finished capture.
    pub monotonic_time_ns: u64,
    pub angle_rad: f64,
    /// Velocity, rad/s; NaN where there is none.
    pub velocity_rad_s: f64,
    /// Accelerometer as read, rad/s²; NaN where there is none.
    pub acceleration_rad_s2: f64,
    /// Torque sensor as read, mNm; of a rendered knob what it takes from the hand.
    pub torque_mnm: f64,
    /// Whether the contact was closed: 1, or 0; NaN where none is watched.
    pub contact: f64,
    pub turning_positive: bool,
    /// Whether the knob sticks, where it says so itself, as a rendered one does.
    pub stuck: Option<bool>,
}

impl Reading {
    /// The reading of one sample of a run at `rate_hz`.
    pub fn of(sample: &Sample, rate_hz: f64, is_rendered: bool) -> Self {
        Self {
            time_ns: nanoseconds(sample.time_s(rate_hz)),
            monotonic_time_ns: sample.monotonic_time_ns,
            angle_rad: sample.angle_rad,
            velocity_rad_s: sample.velocity_rad_s,
            acceleration_rad_s2: sample.acceleration_rad_s2,
            // The sensor of a rig that renders reads that torque with the opposite sign.
            torque_mnm: if is_rendered { -sample.torque_mnm } else { sample.torque_mnm },
            contact: sample.contact,
            turning_positive: sample.velocity_rad_s > 0.0,
            stuck: is_rendered.then_some(sample.flags & Sample::STUCK != 0),
        }
    }
}

/// A time in a run as the screen has it.
pub fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9).round() as i64
}

/// A running rig, or a capture that one left behind.
pub trait Source {
    /// Hands everything that has come since the last call over to `picture`; does not wait. Samples are not wanted while the
    /// rate is unknown: without a time they cannot be drawn, and wait in the source. Fails when the source has failed for good.
    fn poll(&mut self, samples_wanted: bool, picture: &mut Picture) -> anyhow::Result<()>;
}
