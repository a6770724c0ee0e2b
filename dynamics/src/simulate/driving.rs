//! The torque that drives a predicted motion.

use crate::Motion;

/// The motor that turns a knob, as the rig's calibration and a capture tell it.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct RigMotor {
    /// Inertia on the motor's side of the torque sensor, mNm·s²/rad.
    pub inertia: f64,
    /// Coulomb friction of the motor, which it also holds at rest, mNm.
    pub coulomb_mnm: f64,
    /// Viscous friction of the motor, mNm·s/rad.
    pub viscous: f64,
}

/// What a prediction is driven by, a value for each sample.
pub(super) enum Driving<'a> {
    /// The torque that the knob took; between samples it goes in straight lines.
    Measured(&'a [f64]),
    /// The torque commanded from the motor, held from sample to sample.
    Commanded {
        /// The commands, mNm.
        torque_mnm: &'a [f64],
        /// The motor.
        motor: &'a RigMotor,
        /// All that the motor turns, itself included, mNm·s²/rad.
        inertia: f64,
    },
}

impl Driving<'_> {
    /// Torque on motor, knob and what turns with them at sample `index`, where `motion` is predicted, mNm.
    pub(super) fn at(&self, index: usize, motion: &Motion, step_s: f64) -> f64 {
        match self {
            Self::Measured(torque_mnm) => torque_mnm[index],
            Self::Commanded { torque_mnm, motor, inertia } => {
                torque_mnm[index] - motor.friction_mnm(torque_mnm[index], motion.velocity_rad_s, inertia / step_s)
            }
        }
    }

    /// Torque at both ends of the step from sample `index` − 1 to `index`, mNm; `from` is the motion predicted at the first.
    pub(super) fn over_step(&self, index: usize, from: &Motion, step_s: f64) -> [f64; 2] {
        let start = self.at(index - 1, from, step_s);
        match self {
            Self::Measured(torque_mnm) => [start, torque_mnm[index]],
            Self::Commanded { .. } => [start, start],
        }
    }

    /// Whether the torque at a sample is known.
    pub(super) fn is_known(&self, index: usize) -> bool {
        match self {
            Self::Measured(torque_mnm) | Self::Commanded { torque_mnm, .. } => torque_mnm[index].is_finite(),
        }
    }
}

impl RigMotor {
    /// Friction over a step, mNm: at rest it holds against `torque_mnm`, in motion it never reverses what it brakes.
    ///
    /// `stopping_mnm_s_rad` is the torque that takes a unit of speed away within the step.
    fn friction_mnm(&self, torque_mnm: f64, velocity_rad_s: f64, stopping_mnm_s_rad: f64) -> f64 {
        if velocity_rad_s == 0.0 {
            return torque_mnm.clamp(-self.coulomb_mnm, self.coulomb_mnm);
        }
        let sliding_mnm = self.coulomb_mnm + self.viscous * velocity_rad_s.abs();
        sliding_mnm.min(stopping_mnm_s_rad * velocity_rad_s.abs()).copysign(velocity_rad_s)
    }
}
