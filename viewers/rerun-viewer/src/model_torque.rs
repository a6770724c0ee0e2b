//! The torque that the fitted model gives, to be drawn over the measured one.
//!
//! ```text
//! τ = M·θ̈ + [θ̇<0]·(−C₋ + B₋·θ̇) + [θ̇>0]·(C₊ + B₊·θ̇) + A·sin(θ/P + S)
//! ```
//!
//! Where the torque was measured point by point instead of detents, that is in their place.
//!
//! A term whose parameters the data cannot tell is left out; where that is Coulomb friction there is
//! no torque for turning in its direction. On a rig the torque sensor also bears the gripper and has
//! a zero of its own, see [`KnobModel::on_rig`].

use std::f64::consts::{PI, TAU};

use dynamics::{Calibration, Direction, Effect, Motion};
use shared_types::{Estimate, FitUpdate, Verdict};

use crate::entities::PARAMETERS;
use crate::half_widths::HalfWidths;

/// Equation 1 with the parameters of one fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnobModel {
    /// M, mNm s²/rad.
    inertia: f64,
    negative: Option<Friction>,
    positive: Option<Friction>,
    detent: Option<Detent>,
    /// What was measured over the angle: the mean of both directions, and friction.
    characteristic: [Option<Effect>; 2],
    /// What the torque sensor reads with nothing attached, mNm.
    zero_mnm: f64,
    half_widths: HalfWidths,
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
    /// The model of a fit; `None` until a parameter is identified.
    pub fn from_fit(fit: &FitUpdate) -> Option<Self> {
        let estimates = fit.estimates();
        let value =
            |name: &str| estimates.iter().find(|(known, _)| *known == name).and_then(|(_, found)| finite_value(found));
        let half_width = |name: &str| {
            let (_, estimate) = estimates.iter().find(|(known, _)| *known == name)?;
            finite_value(estimate).map(|_| estimate.half_width())
        };
        Self::from_values(value).map(|model| model.with_half_widths(half_width))
    }

    /// The model of the parameters for which `value_of` returns a value, by their standard names; `None` if there are none.
    pub fn from_values(value_of: impl Fn(&str) -> Option<f64>) -> Option<Self> {
        let or_zero = |name: &str| value_of(name).unwrap_or(0.0);
        let friction =
            |coulomb: &str, viscous: &str| Some(Friction { coulomb: value_of(coulomb)?, viscous: or_zero(viscous) });
        let detent = match (value_of("detent_amplitude"), value_of("detent_period"), value_of("detent_phase")) {
            (Some(amplitude), Some(period), Some(phase)) if period != 0.0 => Some(Detent { amplitude, period, phase }),
            _ => None,
        };
        PARAMETERS.iter().any(|(name, _)| value_of(name).is_some()).then(|| Self {
            inertia: or_zero("inertia"),
            negative: friction("coulomb_negative", "viscous_negative"),
            positive: friction("coulomb_positive", "viscous_positive"),
            detent,
            characteristic: [None; 2],
            zero_mnm: 0.0,
            half_widths: HalfWidths::default(),
        })
    }

    /// The model with the half widths of its parameters' 95 % intervals, by their standard names.
    #[must_use]
    pub fn with_half_widths(self, half_width_of: impl Fn(&str) -> Option<f64>) -> Self {
        Self { half_widths: HalfWidths::from_values(half_width_of), ..self }
    }

    /// The model with what a fit measured over the angle, and the half width of its 95 % interval, mNm.
    #[must_use]
    pub fn with_characteristic(self, effects: &[Effect], half_width_mnm: f64) -> Self {
        let mut measured = effects.iter().filter(|effect| effect.table().is_some()).copied();
        let characteristic = [measured.next(), measured.next()];
        Self { characteristic, half_widths: self.half_widths.with_characteristic(half_width_mnm), ..self }
    }

    /// The model as the rig's torque sensor reads it: with the gripper and the sensor's zero.
    #[must_use]
    pub fn on_rig(self, calibration: &Calibration) -> Self {
        Self {
            inertia: self.inertia + calibration.gripper_inertia,
            zero_mnm: self.zero_mnm + calibration.torque_zero_mnm,
            ..self
        }
    }

    /// The whole torque, mNm; NaN where the friction is not identified.
    pub fn torque_mnm(&self, angle_rad: f64, velocity_rad_s: f64, acceleration_rad_s2: f64) -> f64 {
        self.zero_mnm
            + self.inertia * acceleration_rad_s2
            + self.friction_mnm(velocity_rad_s)
            + self.detent_mnm(angle_rad)
            + self.characteristic_mnm(angle_rad, velocity_rad_s)
    }

    /// Torque measured over the angle, mNm.
    fn characteristic_mnm(&self, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        let motion = Motion { angle_rad, velocity_rad_s, ..Motion::default() };
        let torque_mnm = |effect: &Effect| {
            let slides = if velocity_rad_s == 0.0 { 0.0 } else { 1.0 };
            effect.free_torque_mnm(&motion) + slides * effect.friction_mnm(&motion, Direction::of(velocity_rad_s))
        };
        self.characteristic.iter().flatten().map(torque_mnm).sum()
    }

    /// Least and largest torque while turning at that velocity, whatever the angle, beside zero and friction, mNm; none where the
    /// torque does not depend on the angle.
    pub fn range_over_angle_mnm(&self, velocity_rad_s: f64) -> Option<[f64; 2]> {
        let table = self.characteristic.iter().flatten().find_map(Effect::table);
        match (table, self.detent) {
            (Some(table), _) => {
                let torques = || table.points().iter().map(|angle| self.characteristic_mnm(*angle, velocity_rad_s));
                Some([torques().fold(f64::INFINITY, f64::min), torques().fold(f64::NEG_INFINITY, f64::max)])
            }
            (None, Some(detent)) => Some([-detent.amplitude.abs(), detent.amplitude.abs()]),
            (None, None) => None,
        }
    }

    /// The torque without any motion or detent, mNm.
    pub const fn zero_mnm(&self) -> f64 {
        self.zero_mnm
    }

    /// Friction torque, mNm; none at rest, NaN where it is not identified.
    pub fn friction_mnm(&self, velocity_rad_s: f64) -> f64 {
        let sliding = |friction: Option<Friction>| {
            friction.map_or(f64::NAN, |Friction { coulomb, viscous }| {
                coulomb * velocity_rad_s.signum() + viscous * velocity_rad_s
            })
        };
        if velocity_rad_s < 0.0 {
            sliding(self.negative)
        } else if velocity_rad_s > 0.0 {
            sliding(self.positive)
        } else {
            0.0
        }
    }

    /// Detent torque, mNm.
    pub fn detent_mnm(&self, angle_rad: f64) -> f64 {
        self.detent.map_or(0.0, |Detent { amplitude, period, phase }| amplitude * (angle_rad / period + phase).sin())
    }

    /// Half of the 95 % interval of the friction torque, mNm.
    pub fn friction_half_width_mnm(&self, velocity_rad_s: f64) -> f64 {
        self.half_widths.friction_mnm(velocity_rad_s)
    }

    /// Half of the 95 % interval of friction and detents together, mNm.
    pub fn half_width_mnm(&self, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        let detent = self.detent.map_or(0.0, |Detent { amplitude, period, phase }| {
            self.half_widths.detent_mnm([amplitude, period, phase], angle_rad)
        });
        self.friction_half_width_mnm(velocity_rad_s).hypot(detent).hypot(self.half_widths.characteristic_mnm())
    }

    /// How deep in a detent an angle is: 1 where the knob rests, −1 between two detents, 0 without detents.
    pub fn detent_depth(&self, angle_rad: f64) -> f64 {
        self.detent.map_or(0.0, |Detent { amplitude, period, phase }| {
            // The torque turns positive where its integral, the energy, is least.
            (amplitude * period).signum() * (angle_rad / period + phase).cos()
        })
    }

    /// Angles from `low_rad` to `high_rad` at which the knob rests.
    #[allow(clippy::cast_possible_truncation, reason = "angles are a few turns")]
    pub fn stable_angles_rad(&self, low_rad: f64, high_rad: f64) -> Vec<f64> {
        let Some(Detent { amplitude, period, phase }) = self.detent else { return Vec::new() };
        let offset = if amplitude * period > 0.0 { 0.0 } else { PI };
        let number = |angle: f64| (angle / period + phase - offset) / TAU;
        let (first, last) = (number(low_rad).min(number(high_rad)), number(low_rad).max(number(high_rad)));
        (first.ceil() as i64..=last.floor() as i64)
            .map(|number| period * (TAU * number as f64 + offset - phase))
            .collect()
    }

    /// Largest detent torque, mNm.
    pub fn detent_amplitude_mnm(&self) -> f64 {
        self.detent.map_or(0.0, |detent| detent.amplitude.abs())
    }

    /// Angle from detent to detent, rad.
    pub fn detent_spacing_rad(&self) -> Option<f64> {
        self.detent.map(|detent| TAU * detent.period.abs())
    }
}

/// The value of a parameter that the data can tell.
pub fn finite_value(estimate: &Estimate) -> Option<f64> {
    (Verdict::from_code(estimate.verdict) == Some(Verdict::Estimated) && estimate.value.is_finite())
        .then_some(estimate.value)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// The calibration of some rig.
    pub(crate) fn calibration() -> Calibration {
        Calibration {
            axis: dynamics::Axis::Rotary,
            gripper_inertia: 0.004,
            motor_inertia: 0.016,
            torque_sensor_stiffness_mnm_rad: 5e5,
            torque_zero_mnm: 0.6,
            torque_delay_s: 0.0,
            acceleration_zero_rad_s2: 0.0,
            acceleration_delay_s: 0.0,
            gravity_amplitude_rad_s2: 0.0,
            gravity_phase_rad: 0.0,
            angle_step_rad: 1e-5,
            torque_step_mnm: 0.18,
            acceleration_step_rad_s2: 2.8,
            motor_coulomb_mnm: None,
            motor_viscous: None,
            command_delay_s: None,
            motor_cogging: None,
        }
    }

    fn enough(value: f64) -> Estimate {
        Estimate { value, ci95_low: value, ci95_high: value, verdict: Verdict::Estimated.code(), convergence: 0 }
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
    fn a_term_that_is_not_identified_is_left_out() {
        let mut fit = knob_three();
        fit.detent_period.verdict = Verdict::NotYet.code();
        fit.inertia.value = f64::NAN;
        let model = KnobModel::from_fit(&fit).unwrap();
        assert_eq!(model.torque_mnm(0.1, 1.0, 1_000.0), 2.3 - 0.24);
        assert_eq!(model.detent_spacing_rad(), None);
    }

    #[test]
    #[allow(clippy::unwrap_used, reason = "test")]
    fn turning_in_a_direction_whose_friction_is_not_identified_has_no_torque() {
        let mut fit = knob_three();
        fit.coulomb_negative.verdict = Verdict::NotYet.code();
        let model = KnobModel::from_fit(&fit).unwrap();
        assert!(model.torque_mnm(0.1, -2.0, 100.0).is_nan());
        assert!(model.torque_mnm(0.1, 2.0, 100.0).is_finite());
    }

    #[test]
    #[allow(clippy::unwrap_used, reason = "test")]
    fn on_the_rig_the_sensor_also_bears_the_gripper_and_has_its_zero() {
        let calibration = calibration();
        let knob = KnobModel::from_fit(&knob_three()).unwrap();
        let more_mnm = knob.on_rig(&calibration).torque_mnm(0.1, 2.0, 100.0) - knob.torque_mnm(0.1, 2.0, 100.0);
        assert!((more_mnm - (0.6 + 0.4)).abs() < 1e-12);
    }

    #[test]
    fn before_any_parameter_is_identified_there_is_no_model() {
        assert_eq!(KnobModel::from_fit(&FitUpdate::default()), None);
    }
}
