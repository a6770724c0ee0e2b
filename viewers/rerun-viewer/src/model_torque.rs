//! The torque that the fitted model gives, to be drawn over the measured one.
//!
//! ```text
//! τ = M·θ̈ + [θ̇<0]·(−C₋ + B₋·θ̇) + [θ̇>0]·(C₊ + B₊·θ̇) + A·sin(θ/P + S)
//! ```
//!
//! A term whose parameters the data cannot tell yet is left out.

use shared_types::{Estimate, FitUpdate, Verdict};

/// Equation 1 with the parameters of one fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnobModel {
    /// M, mNm s²/rad.
    inertia: f64,
    negative: Friction,
    positive: Friction,
    detent: Option<Detent>,
}

/// Friction in one direction of turning.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Friction {
    /// Magnitude, mNm.
    coulomb: f64,
    /// mNm s/rad.
    viscous: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Detent {
    amplitude: f64,
    period: f64,
    phase: f64,
}

impl KnobModel {
    /// The model of a fit; `None` while no parameter can be told.
    pub fn from_fit(fit: &FitUpdate) -> Option<Self> {
        let known: Vec<bool> = fit.estimates().iter().map(|(_, estimate)| told(estimate).is_some()).collect();
        let or_zero = |estimate: &Estimate| told(estimate).unwrap_or(0.0);
        let detent = match (told(&fit.detent_amplitude), told(&fit.detent_period), told(&fit.detent_phase)) {
            (Some(amplitude), Some(period), Some(phase)) if period != 0.0 => Some(Detent { amplitude, period, phase }),
            _ => None,
        };
        known.contains(&true).then(|| Self {
            inertia: or_zero(&fit.inertia),
            negative: Friction { coulomb: or_zero(&fit.coulomb_negative), viscous: or_zero(&fit.viscous_negative) },
            positive: Friction { coulomb: or_zero(&fit.coulomb_positive), viscous: or_zero(&fit.viscous_positive) },
            detent,
        })
    }

    /// The whole torque, mNm.
    pub fn torque_mnm(&self, angle_rad: f64, velocity_rad_s: f64, acceleration_rad_s2: f64) -> f64 {
        self.inertia * acceleration_rad_s2 + self.friction_mnm(velocity_rad_s) + self.detent_mnm(angle_rad)
    }

    /// Friction torque, mNm; none at rest.
    pub fn friction_mnm(&self, velocity_rad_s: f64) -> f64 {
        if velocity_rad_s < 0.0 {
            -self.negative.coulomb + self.negative.viscous * velocity_rad_s
        } else if velocity_rad_s > 0.0 {
            self.positive.coulomb + self.positive.viscous * velocity_rad_s
        } else {
            0.0
        }
    }

    /// Detent torque, mNm.
    pub fn detent_mnm(&self, angle_rad: f64) -> f64 {
        self.detent.map_or(0.0, |Detent { amplitude, period, phase }| amplitude * (angle_rad / period + phase).sin())
    }

    /// Largest detent torque, mNm.
    pub fn detent_amplitude_mnm(&self) -> f64 {
        self.detent.map_or(0.0, |detent| detent.amplitude.abs())
    }

    /// Angle from detent to detent, rad.
    pub fn detent_spacing_rad(&self) -> Option<f64> {
        self.detent.map(|detent| std::f64::consts::TAU * detent.period.abs())
    }
}

/// The value of a parameter that the data can tell.
pub fn told(estimate: &Estimate) -> Option<f64> {
    (Verdict::from_code(estimate.verdict) == Some(Verdict::Enough) && estimate.value.is_finite())
        .then_some(estimate.value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn enough(value: f64) -> Estimate {
        Estimate { value, ci95_low: value, ci95_high: value, verdict: Verdict::Enough.code(), reserved: 0 }
    }

    /// Knob 3 of the paper's Table 5.
    fn knob_three() -> FitUpdate {
        FitUpdate {
            inertia: enough(0.035),
            coulomb_negative: enough(2.3),
            viscous_negative: enough(-0.15),
            coulomb_positive: enough(2.3),
            viscous_positive: enough(-0.24),
            detent_amplitude: enough(1.1),
            detent_period: enough(0.034),
            detent_phase: enough(0.16),
            ..FitUpdate::default()
        }
    }

    #[test]
    #[allow(clippy::unwrap_used, reason = "test")]
    fn the_torque_of_knob_three_is_equation_one_worked_by_hand() {
        let model = KnobModel::from_fit(&knob_three()).unwrap();
        // 0.035·100 + 2.3 − 0.24·2 + 1.1·sin(0.1/0.034 + 0.16) = 5.32 + 1.1·sin(3.101176)
        assert!((model.torque_mnm(0.1, 2.0, 100.0) - 5.364_445).abs() < 1e-5);
        // −2.3 + (−0.15)(−2) + 1.1·sin(0.16)
        assert!((model.torque_mnm(0.0, -2.0, 0.0) - -1.824_750).abs() < 1e-5);
    }

    #[test]
    #[allow(clippy::unwrap_used, reason = "test")]
    fn a_knob_at_rest_has_no_friction_torque_in_the_model() {
        let model = KnobModel::from_fit(&knob_three()).unwrap();
        assert_eq!(model.friction_mnm(0.0), 0.0);
    }

    #[test]
    #[allow(clippy::unwrap_used, reason = "test")]
    fn a_term_that_cannot_be_told_is_left_out() {
        let mut fit = knob_three();
        fit.detent_period.verdict = Verdict::NotYet.code();
        fit.inertia.value = f64::NAN;
        let model = KnobModel::from_fit(&fit).unwrap();
        assert_eq!(model.torque_mnm(0.1, 1.0, 1_000.0), 2.3 - 0.24);
        assert_eq!(model.detent_spacing_rad(), None);
    }

    #[test]
    fn before_anything_is_told_there_is_no_model() {
        assert_eq!(KnobModel::from_fit(&FitUpdate::default()), None);
    }
}
