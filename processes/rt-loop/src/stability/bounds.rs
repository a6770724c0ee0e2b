//! What can be rendered on a rig, as numbers.

use dynamics::{Calibration, Direction, Model, Motion};
use hal::Limits;

use super::port::{Hands, LinearModel, Port};
use crate::control::rendering::RenderGains;

/// A model that passes what the rig can render.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value:.4} {unit}, but the rig renders {relation} {bound:.4} {unit}: {remedy}")]
pub struct BoundExceeded {
    /// What passes its bound.
    pub what: &'static str,
    /// Its value in the model.
    pub value: f64,
    /// The nearest that would do.
    pub bound: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// "at most" or "at least".
    pub relation: &'static str,
    /// What to change.
    pub remedy: &'static str,
}

/// What can be rendered without any hand of the class being able to make it swing, and within the motor's torque.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Least inertia: rotor and gripper, mNm·s²/rad.
    pub least_inertia: f64,
    /// Largest inertia, mNm·s²/rad.
    pub largest_inertia: f64,
    /// Largest rise of friction with speed, mNm·s/rad.
    pub largest_damping: f64,
    /// Steepest rise of torque with angle, mNm/rad.
    pub largest_stiffness_mnm_rad: f64,
    /// Largest torque, mNm.
    pub largest_torque_mnm: f64,
    /// Frequency below which a knob at rest, or the lightest, takes energy in whatever moves it, Hz.
    pub passive_to_hz: f64,
}

/// Share of the motor's torque that may be the model's: the rest holds against noise and the hand.
const MODEL_SHARE: f64 = 0.9;
/// Share of what zero exclusion permits that is permitted: the calibration is known to some per cent.
const SAFETY: f64 = 0.8;

impl Bounds {
    /// The bounds of a rig under these gains.
    #[must_use]
    pub fn of(gains: &RenderGains, calibration: &Calibration, limits: &Limits, rate_hz: f64) -> Self {
        let port = Port::new(*gains, calibration, rate_hz);
        let least_inertia = calibration.motor_inertia + calibration.gripper_inertia;
        let hands = Hands::default();
        let sliding = |inertia: f64, damping: f64, stiffness_mnm_rad: f64| LinearModel::Sliding {
            inertia,
            damping,
            stiffness_mnm_rad,
        };
        let largest = |from: f64, to: f64, of: &dyn Fn(f64) -> LinearModel| {
            SAFETY * largest_safe(from, to, |value| port.is_safe(&of(value), &hands))
        };
        Self {
            least_inertia,
            largest_inertia: largest(least_inertia, 1e3, &|inertia| sliding(inertia, 0.0, 0.0)),
            largest_damping: largest(1e-3, 1e4, &|damping| sliding(least_inertia, damping, 0.0)),
            largest_stiffness_mnm_rad: largest(1e-1, 1e6, &|stiffness| sliding(least_inertia, 0.0, stiffness)),
            largest_torque_mnm: MODEL_SHARE * limits.motor_torque_mnm,
            passive_to_hz: 0.0,
        }
    }

    /// Checks a model against the bounds; gives what will be felt otherwise than the model says, in sentences.
    ///
    /// # Errors
    /// [`BoundExceeded`] for the first bound that the model passes.
    pub fn check(&self, model: &Model) -> Result<Vec<String>, BoundExceeded> {
        let demands = Demands::of(model);
        let at_most = |what, value: f64, bound, unit, remedy| {
            if value <= bound {
                Ok(())
            } else {
                Err(BoundExceeded { what, value, bound, unit, relation: "at most", remedy })
            }
        };
        at_most("the inertia", model.inertia(), self.largest_inertia, "mNm·s²/rad", "lower `inertia`")?;
        at_most(
            "the steepest rise of torque over angle",
            demands.stiffness_mnm_rad,
            self.largest_stiffness_mnm_rad,
            "mNm/rad",
            "lower the amplitude or widen the period",
        )?;
        at_most(
            "the steepest rise of friction over speed",
            demands.damping,
            self.largest_damping,
            "mNm·s/rad",
            "lower the viscous friction",
        )?;
        at_most(
            "the largest torque",
            demands.torque_mnm,
            self.largest_torque_mnm,
            "mNm",
            "lower the amplitude, the static or the Coulomb friction",
        )?;
        let drives = demands.drives_from_rad_s.map(|speed_rad_s| {
            format!("friction would drive the knob from {speed_rad_s:.1} rad/s on; it is held at zero there")
        });
        Ok(drives.into_iter().collect())
    }
}

/// The largest value up to which every one on the way is safe, on a ladder of 2 % steps.
fn largest_safe(from: f64, to: f64, is_safe: impl Fn(f64) -> bool) -> f64 {
    let mut safe = 0.0;
    let mut value = from;
    while value <= to && is_safe(value) {
        safe = value;
        value *= 1.02;
    }
    safe
}

/// What a model demands of a rig.
struct Demands {
    stiffness_mnm_rad: f64,
    damping: f64,
    torque_mnm: f64,
    /// Speed from which friction would drive instead of brake, rad/s.
    drives_from_rad_s: Option<f64>,
}

/// Angles over which a model is looked at either way, rad: a turn.
const LOOKED_AT_RAD: f64 = std::f64::consts::TAU;
/// Step of looking, rad: a thirtieth of the finest detent that a finger counts.
const LOOKED_AT_STEP_RAD: f64 = 2e-4;
/// Fastest a hand turns a knob, rad/s.
const FASTEST_RAD_S: f64 = 40.0;

impl Demands {
    #[allow(clippy::cast_possible_truncation, reason = "some ten thousand steps")]
    fn of(model: &Model) -> Self {
        let steps = (LOOKED_AT_RAD / LOOKED_AT_STEP_RAD) as i32;
        let at = |step: i32| Motion { angle_rad: f64::from(step) * LOOKED_AT_STEP_RAD, ..Motion::default() };
        let (mut stiffness_mnm_rad, mut free_mnm, mut held_mnm) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut before_mnm = model.free_torque_mnm(&at(-steps));
        for step in -steps + 1..=steps {
            let motion = at(step);
            let torque_mnm = model.free_torque_mnm(&motion);
            stiffness_mnm_rad = stiffness_mnm_rad.max((torque_mnm - before_mnm).abs() / LOOKED_AT_STEP_RAD);
            before_mnm = torque_mnm;
            free_mnm = free_mnm.max(torque_mnm.abs());
            let limits = model.stick_limits(&motion);
            held_mnm = held_mnm.max(limits.negative_mnm).max(limits.positive_mnm);
        }
        let (mut damping, mut sliding_mnm, mut drives_from_rad_s) = (0.0_f64, 0.0_f64, None::<f64>);
        for direction in [Direction::Negative, Direction::Positive] {
            let friction_mnm = |speed_rad_s: f64| {
                let motion = Motion { velocity_rad_s: direction.sign() * speed_rad_s, ..Motion::default() };
                direction.sign() * model.friction_mnm(&motion, direction)
            };
            let speeds = (1..=400).map(|step| FASTEST_RAD_S * f64::from(step) / 400.0);
            for speed_rad_s in speeds {
                let braking_mnm = friction_mnm(speed_rad_s);
                let slope = (braking_mnm - friction_mnm(speed_rad_s - FASTEST_RAD_S / 400.0)) / (FASTEST_RAD_S / 400.0);
                damping = damping.max(slope);
                sliding_mnm = sliding_mnm.max(braking_mnm);
                if braking_mnm < 0.0 {
                    drives_from_rad_s = Some(drives_from_rad_s.map_or(speed_rad_s, |known| known.min(speed_rad_s)));
                }
            }
        }
        Self { stiffness_mnm_rad, damping, torque_mnm: free_mnm + held_mnm.max(sliding_mnm), drives_from_rad_s }
    }
}
