//! What is known of a rig, found out from captures of it.

use dynamics::Calibration;
use identification::calibration::{self, CalibrateError, Calibrated};
use loaded_capture::LoadedCapture;

/// What of a rig is calibrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum CalibrationKind {
    /// Gravity in the acceleration signal, from a slow turn of more than 360°.
    Gravity,
    /// The readings of torque sensor and accelerometer at rest, with nothing on the gripper.
    Zero,
    /// The gripper's inertia, from a sweep of the gripper alone.
    Gripper,
    /// Delays of torque and acceleration, from fast sines of the gripper alone.
    Latency,
    /// The motor's cogging, from slow turns of the gripper alone in both directions.
    Cogging,
    /// The motor's own inertia and friction, from a sweep of the gripper alone.
    Friction,
}

impl CalibrationKind {
    /// Determines this part of the calibration from a capture, given what is known of the rig.
    ///
    /// # Errors
    /// [`CalibrateError`], the reason why the capture does not determine it.
    pub fn calibrate(self, loaded: &LoadedCapture, known: &Calibration) -> Result<Calibrated, CalibrateError> {
        let samples = &loaded.samples();
        match self {
            Self::Cogging | Self::Friction => {
                let commanded_mnm = loaded.commanded_torque_mnm().ok_or(CalibrateError::NoCommand)?;
                let of_motor = if self == Self::Cogging { calibration::cogging } else { calibration::friction };
                of_motor(samples, commanded_mnm, known)
            }
            Self::Gravity => calibration::gravity(samples, known),
            Self::Zero => calibration::zero(samples, known),
            Self::Gripper => calibration::gripper(samples, known),
            Self::Latency => latency(loaded, known),
        }
    }

    /// What it is about, as a noun.
    #[must_use]
    pub fn subject(self) -> &'static str {
        match self {
            Self::Gravity => "gravity",
            Self::Zero => "zeros",
            Self::Gripper => "gripper",
            Self::Latency => "delays",
            Self::Cogging => "cogging",
            Self::Friction => "friction",
        }
    }
}

/// The delays of the channels, and of the motor where the capture says when a command acts.
fn latency(loaded: &LoadedCapture, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    let samples = &loaded.samples();
    let mut calibrated = calibration::latency(samples, known)?;
    let late_ticks = loaded.capture.description.as_ref().and_then(|run| run.torque_late_ticks);
    if let Some((commanded_mnm, late_ticks)) = loaded.commanded_torque_mnm().zip(late_ticks) {
        match calibration::command_latency(samples, commanded_mnm, late_ticks, known) {
            Ok(delay) => calibrated.estimates.push(delay),
            Err(error) => calibrated.notes.push(format!("no delay of the motor: {error}")),
        }
    }
    Ok(calibrated)
}
