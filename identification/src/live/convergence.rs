//! Whether a parameter is known with the precision asked for.
//!
//! A parameter has converged when half the width of its 95 % interval is at most the asked share of its value. Two cases
//! need a rule of their own:
//!
//! - A **phase** has no size of its own, since its zero depends on the encoder's. An error of the phase in radians, times the
//!   amplitude, is an error of the detent torque, so the share is taken of one radian.
//! - A parameter **near zero** has no share worth the name. It is negligible once even the far end of its interval makes
//!   less torque, over the motion so far, than one step of the torque sensor: nothing that this rig reads would show it.

use shared_types::Convergence;

/// Share of a value that half its interval may be wide, where nobody asks for another: far below the 13 % of torque that
/// fingers can just tell apart (Jandura and Srinivasan 1994).
pub const USUAL_SHARE: f64 = 0.01;

/// Criterion by which intervals are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// Share of a value that half its interval may be wide, below one.
    pub share: f64,
    /// One step of the torque sensor, mNm.
    pub torque_step_mnm: f64,
}

impl Criterion {
    /// Judges a parameter with `half_width` as half its 95 % interval, after a motion with these RMS values.
    #[must_use]
    pub fn judge(&self, name: &str, value: f64, half_width: f64, motion: MotionRms) -> Convergence {
        let negligible = torque_per_unit(name, motion)
            .is_some_and(|torque_mnm| (value.abs() + half_width) * torque_mnm <= self.torque_step_mnm);
        if relative_half_width(name, value, half_width) <= self.share {
            Convergence::Converged
        } else if negligible {
            Convergence::Negligible
        } else {
            Convergence::Open
        }
    }
}

/// RMS of a motion while the knob slid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionRms {
    /// Of the velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Of the acceleration, rad/s².
    pub acceleration_rad_s2: f64,
}

/// Half an interval as a share of the value; of a phase, of one radian.
pub(super) fn relative_half_width(name: &str, value: f64, half_width: f64) -> f64 {
    if name == "detent_phase" { half_width } else { half_width / value.abs() }
}

/// Torque that one unit of a parameter makes over a motion, mNm; `None` for period and phase, which make none.
fn torque_per_unit(name: &str, motion: MotionRms) -> Option<f64> {
    match name {
        "inertia" => Some(motion.acceleration_rad_s2),
        "viscous_negative" | "viscous_positive" => Some(motion.velocity_rad_s),
        "coulomb_negative" | "coulomb_positive" | "detent_amplitude" => Some(1.0),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::{Convergence, Criterion, MotionRms};

    const CRITERION: Criterion = Criterion { share: 0.01, torque_step_mnm: 0.18 };
    const MOTION: MotionRms = MotionRms { velocity_rad_s: 5.0, acceleration_rad_s2: 100.0 };

    fn judge(name: &str, value: f64, half_width: f64) -> Convergence {
        CRITERION.judge(name, value, half_width, MOTION)
    }

    #[test]
    fn an_interval_is_narrow_by_its_share_of_the_value() {
        assert_eq!(judge("inertia", 0.035, 0.0003), Convergence::Converged);
        assert_eq!(judge("inertia", 0.035, 0.0004), Convergence::Open);
        assert_eq!(judge("inertia", 0.035, f64::NAN), Convergence::Open);
    }

    #[test]
    fn a_parameter_that_the_torque_sensor_cannot_show_is_negligible() {
        // 0.02 + 0.01 mNm s/rad at 5 rad/s are 0.15 mNm, less than a step; 0.03 + 0.01 are more.
        assert_eq!(judge("viscous_positive", 0.02, 0.01), Convergence::Negligible);
        assert_eq!(judge("viscous_positive", -0.02, 0.01), Convergence::Negligible);
        assert_eq!(judge("viscous_positive", 0.03, 0.01), Convergence::Open);
    }

    #[test]
    fn a_phase_is_judged_by_the_torque_that_it_moves() {
        assert_eq!(judge("detent_phase", 0.001, 0.007), Convergence::Converged);
        assert_eq!(judge("detent_phase", 3.0, 0.02), Convergence::Open);
    }
}
