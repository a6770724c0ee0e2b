//! The result of a calibration, and why there may be none.

use dynamics::{Calibration, CoggingHarmonic};

use crate::{FitError, Samples};

/// One calibrated quantity.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Its key in a calibration file.
    pub quantity: &'static str,
    /// Its value.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub half_width: f64,
    /// Unit of both.
    pub unit: &'static str,
}

impl Estimate {
    pub(super) fn new(quantity: &'static str, (value, half_width): (f64, f64), unit: &'static str) -> Self {
        Self { quantity, value, half_width, unit }
    }
}

/// One calibrated harmonic of the motor's cogging.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CoggingEstimate {
    /// Periods in a turn.
    pub per_turn: u32,
    /// Largest torque, mNm.
    pub torque_mnm: f64,
    /// Half width of its 95 % interval, mNm.
    pub torque_half_width_mnm: f64,
    /// Phase at angle zero, rad.
    pub phase_rad: f64,
    /// Half width of its 95 % interval, rad.
    pub phase_half_width_rad: f64,
}

/// The result of a calibration.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Calibrated {
    /// The quantities that it estimates.
    pub estimates: Vec<Estimate>,
    /// The motor's cogging, strongest harmonic first; `None` where it was not looked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cogging: Option<Vec<CoggingEstimate>>,
    /// What a reader should know besides.
    pub notes: Vec<String>,
}

impl Calibrated {
    /// The estimate of a quantity.
    #[must_use]
    pub fn get(&self, quantity: &str) -> Option<&Estimate> {
        self.estimates.iter().find(|estimate| estimate.quantity == quantity)
    }

    /// A calibration with these estimates in place of its own values.
    #[must_use]
    pub fn applied_to(&self, known: &Calibration) -> Calibration {
        let mut calibration = known.clone();
        for estimate in &self.estimates {
            if let Some(field) = field(&mut calibration, estimate.quantity) {
                *field = estimate.value;
            }
        }
        if let Some(cogging) = &self.cogging {
            calibration.motor_cogging = Some(
                cogging
                    .iter()
                    .map(|CoggingEstimate { per_turn, torque_mnm, phase_rad, .. }| CoggingHarmonic {
                        per_turn: *per_turn,
                        torque_mnm: *torque_mnm,
                        phase_rad: *phase_rad,
                    })
                    .collect(),
            );
        }
        calibration
    }
}

/// The field of a calibration with this key, if it is one that is estimated.
fn field<'a>(calibration: &'a mut Calibration, quantity: &str) -> Option<&'a mut f64> {
    Some(match quantity {
        "gripper_inertia" => &mut calibration.gripper_inertia,
        "torque_zero_mnm" => &mut calibration.torque_zero_mnm,
        "torque_delay_s" => &mut calibration.torque_delay_s,
        "acceleration_zero_rad_s2" => &mut calibration.acceleration_zero_rad_s2,
        "acceleration_delay_s" => &mut calibration.acceleration_delay_s,
        "gravity_amplitude_rad_s2" => &mut calibration.gravity_amplitude_rad_s2,
        "gravity_phase_rad" => &mut calibration.gravity_phase_rad,
        "motor_inertia" => &mut calibration.motor_inertia,
        "motor_coulomb_mnm" => calibration.motor_coulomb_mnm.get_or_insert(0.0),
        "command_delay_s" => calibration.command_delay_s.get_or_insert(0.0),
        "motor_viscous" => calibration.motor_viscous.get_or_insert(0.0),
        _ => return None,
    })
}

/// Why a capture calibrates nothing.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CalibrateError {
    /// Not a capture at all, or one that cannot be fitted.
    #[error(transparent)]
    Samples(#[from] FitError),
    /// No accelerometer column.
    #[error("the capture has no acceleration, which this calibration is about; capture with the accelerometer")]
    NoAcceleration,
    /// The knob did not rest.
    #[error("the knob turned by {travel_rad:.4} rad, but zeros are read at rest; capture with `--torque --sweep hold`")]
    NotAtRest {
        /// Distance between the smallest and the largest angle, rad.
        travel_rad: f64,
    },
    /// Less than a full turn.
    #[error(
        "the knob turned through {:.0}°, but gravity shows over a full turn; capture with `--sweep slow-turn --duration-s 15`",
        travel_rad.to_degrees()
    )]
    LessThanATurn {
        /// Distance between the smallest and the largest angle, rad.
        travel_rad: f64,
    },
    /// The capture is mostly something else than what is calibrated.
    #[error("{percent:.0} % of the {channel} is not what {expected}; {remedy}")]
    Unexplained {
        /// The channel.
        channel: &'static str,
        /// Share of the signal that is not explained, %.
        percent: f64,
        /// What it should be.
        expected: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// No column of commands.
    #[error(
        "the capture has no commanded torque, which the motor's losses are computed from; capture on the rig, to an archive"
    )]
    NoCommand,
    /// Cogging that the capture cannot identify.
    #[error(
        "the motor's cogging cannot be identified: {reason}; capture with `--knob none --sweep slow-turn --duration-s 15`"
    )]
    NoCogging {
        /// Why.
        reason: String,
    },
    /// An inertia or a friction that the capture cannot identify.
    #[error("the {part}'s {quantity} cannot be identified: {reason}")]
    NotIdentified {
        /// Of the gripper or the motor.
        part: &'static str,
        /// What.
        quantity: &'static str,
        /// Why.
        reason: String,
    },
}

/// Checks that there is a command at every sample.
pub(super) fn check_command(samples: &Samples<'_>, commanded_mnm: &[f64]) -> Result<(), CalibrateError> {
    let is_whole = commanded_mnm.len() == samples.torque_mnm.len() && commanded_mnm.iter().all(|mnm| mnm.is_finite());
    if is_whole { Ok(()) } else { Err(CalibrateError::NoCommand) }
}
