//! Whether a parameter is known well enough: the plain word beside its value.
//!
//! **Enough** is a parameter whose 95 % interval is so narrow that a longer capture would not change the feel: its
//! half width is below [`RELATIVE`] of the value, or what it is worth in torque is below the torque sensor's step
//! wherever the knob was in the last seconds. Anything else that the model has is **not yet** known well enough.
//!
//! What a half width h is worth in torque, from Equation 1: h itself for Coulomb friction and the detents' amplitude;
//! h·|θ̇| for viscous friction; h·|θ̈| for inertia; A·h for the phase and A·|θ|·h/P² for the period of detents; each at
//! the largest |θ|, |θ̇|, |θ̈| of the last seconds.

use shared_types::{Estimate, FitUpdate, Verdict};

use crate::model_torque::told;

/// Half width of an interval, as a share of the value, below which a parameter is known well enough: far below the 13 %
/// of torque that fingers can just tell apart (Jandura and Srinivasan 1994).
pub const RELATIVE: f64 = 0.01;
/// Step of the paper's torque sensor, mNm; for rigs whose calibration does not tell another.
pub const TORQUE_STEP_MNM: f64 = 0.18;

/// How far the motion reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reach {
    /// Largest magnitude of the angle, rad.
    pub angle_rad: f64,
    /// Largest magnitude of the velocity, rad/s.
    pub velocity_rad_s: f64,
    /// Largest magnitude of the acceleration, rad/s².
    pub acceleration_rad_s2: f64,
}

impl Reach {
    /// From the ranges of the signals, by their fields' names.
    pub fn of_ranges(ranges: &[(&str, Option<(f64, f64)>)]) -> Self {
        let magnitude = |field: &str| {
            let range = ranges.iter().find(|(name, _)| *name == field).and_then(|(_, range)| *range);
            range.map_or(0.0, |(low, high)| low.abs().max(high.abs()))
        };
        Self {
            angle_rad: magnitude("angle_rad"),
            velocity_rad_s: magnitude("velocity_rad_s"),
            acceleration_rad_s2: magnitude("acceleration_rad_s2"),
        }
    }
}

/// The plain word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// A longer capture would not change the feel.
    Enough,
    /// Not told at all, or not well enough.
    NotYet,
    /// The model has no such parameter.
    Absent,
}

impl Known {
    /// As it is shown; empty for a parameter that the model does not have.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Enough => "enough",
            Self::NotYet => "not yet",
            Self::Absent => "",
        }
    }
}

/// How well `name` of this fit is known, with a torque sensor of this step.
pub fn known(name: &str, fit: &FitUpdate, reach: &Reach, torque_step_mnm: f64) -> Known {
    let Some((_, estimate)) = fit.estimates().into_iter().find(|(known, _)| *known == name) else {
        return Known::Absent;
    };
    if Verdict::from_code(estimate.verdict) == Some(Verdict::Absent) {
        return Known::Absent;
    }
    let Some(value) = told(&estimate) else { return Known::NotYet };
    let half_width = half_width(&estimate);
    let narrow = half_width < RELATIVE * value.abs();
    // An interval that is not a number is not narrow.
    if narrow || half_width * torque_per_unit(name, fit, reach) < torque_step_mnm {
        Known::Enough
    } else {
        Known::NotYet
    }
}

/// Half of a 95 % interval.
pub fn half_width(estimate: &Estimate) -> f64 {
    (estimate.ci95_high - estimate.ci95_low) / 2.0
}

/// Largest torque, mNm, that one unit of the parameter is worth; infinite where the detents cannot be told.
fn torque_per_unit(name: &str, fit: &FitUpdate, reach: &Reach) -> f64 {
    let amplitude = told(&fit.detent_amplitude).map_or(f64::INFINITY, f64::abs);
    match name {
        "inertia" => reach.acceleration_rad_s2,
        "viscous_negative" | "viscous_positive" => reach.velocity_rad_s,
        "detent_phase" => amplitude,
        "detent_period" => {
            told(&fit.detent_period).map_or(f64::INFINITY, |period| amplitude * reach.angle_rad / (period * period))
        }
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(value: f64, half_width: f64) -> Estimate {
        let verdict = Verdict::Enough.code();
        Estimate { value, ci95_low: value - half_width, ci95_high: value + half_width, verdict, reserved: 0 }
    }

    const REACH: Reach = Reach { angle_rad: 0.3, velocity_rad_s: 4.0, acceleration_rad_s2: 100.0 };

    fn is_enough(name: &str, fit: &FitUpdate) -> bool {
        known(name, fit, &REACH, TORQUE_STEP_MNM) == Known::Enough
    }

    #[test]
    fn below_one_percent_or_below_the_sensors_step_is_enough() {
        let with =
            |value, half_width| FitUpdate { coulomb_positive: estimate(value, half_width), ..FitUpdate::default() };
        // 1 % of 40 mNm is above the sensor's step, 1 % of 2.3 mNm below it.
        assert!(is_enough("coulomb_positive", &with(40.0, 0.39)));
        assert!(!is_enough("coulomb_positive", &with(40.0, 0.41)));
        assert!(is_enough("coulomb_positive", &with(2.3, 0.17)));
        assert!(!is_enough("coulomb_positive", &with(2.3, 0.19)));
    }

    #[test]
    fn what_an_interval_is_worth_depends_on_how_fast_the_knob_was_turned() {
        // 0.04 mNm s/rad at 4 rad/s is 0.16 mNm; 0.001 mNm s²/rad at 100 rad/s² is 0.1 mNm.
        let fit = FitUpdate {
            viscous_negative: estimate(-0.15, 0.04),
            inertia: estimate(0.035, 0.001),
            ..FitUpdate::default()
        };
        assert!(is_enough("viscous_negative", &fit) && is_enough("inertia", &fit));
        let faster = Reach { velocity_rad_s: 8.0, acceleration_rad_s2: 400.0, ..REACH };
        assert_eq!(known("viscous_negative", &fit, &faster, TORQUE_STEP_MNM), Known::NotYet);
        assert_eq!(known("inertia", &fit, &faster, TORQUE_STEP_MNM), Known::NotYet);
    }

    #[test]
    fn phase_and_period_count_by_the_torque_that_they_shift() {
        let fit = |phase, period| FitUpdate {
            detent_amplitude: estimate(1.1, 0.01),
            detent_period: estimate(0.034, period),
            detent_phase: estimate(0.16, phase),
            ..FitUpdate::default()
        };
        // 1.1 mNm · 0.16 rad; 1.1 mNm · 0.3 rad · 0.0006 rad / (0.034 rad)².
        assert!(is_enough("detent_phase", &fit(0.16, 1e-5)) && !is_enough("detent_phase", &fit(0.17, 1e-5)));
        assert!(is_enough("detent_period", &fit(0.1, 0.0006)) && !is_enough("detent_period", &fit(0.1, 0.0007)));
    }

    #[test]
    fn what_cannot_be_told_is_not_yet_known_and_what_the_model_lacks_is_absent() {
        let mut fit = FitUpdate { inertia: estimate(0.035, 1e-6), ..FitUpdate::default() };
        fit.inertia.verdict = Verdict::NotYet.code();
        fit.detent_phase.verdict = Verdict::Absent.code();
        assert_eq!(known("inertia", &fit, &REACH, TORQUE_STEP_MNM), Known::NotYet);
        assert_eq!(known("detent_phase", &fit, &REACH, TORQUE_STEP_MNM), Known::Absent);
        let open = FitUpdate { inertia: estimate(0.035, f64::NAN), ..FitUpdate::default() };
        assert_eq!(known("inertia", &open, &REACH, TORQUE_STEP_MNM), Known::NotYet);
    }
}
