//! The torque that the fitted model gives, to be drawn over the measured one.
//!
//! A term whose parameters the data cannot tell is left out; where that is Coulomb friction there is
//! no torque for turning in its direction. On a rig the torque sensor also bears the gripper and has
//! a zero of its own, see [`KnobModel::on_rig`].
//!
//! The torque's interval follows from the parameters' intervals: each half width h moves the torque by h·∂τ/∂p, and these
//! contributions are added in quadrature, as if they were independent. The live fitter does not publish the correlations of the
//! parameters' errors, so this is an approximation: where errors compensate each other, as those of Coulomb and viscous friction
//! mostly do, the interval is too wide.

use dynamics::effects::{detent, friction, inertia};
use dynamics::{Calibration, Direction, Effect, EffectKind, Model, Motion};
use shared_types::{Estimate, FitUpdate, Verdict};

use crate::entities::{EQUATION_ONE, parameters};
use crate::extent::{self, Extent};

/// Equation 1 with the parameters of one fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KnobModel {
    /// Inertia, friction, detents if they are identified, and what was measured over the angle instead. Coulomb friction
    /// that the data cannot tell is NaN.
    model: Model,
    /// Half of the 95 % interval in the place of each value; 0 for what the model does not have.
    half_widths: Model,
    characteristic_half_width_mnm: f64,
    /// What the torque sensor reads with nothing attached, mNm.
    zero_mnm: f64,
}

impl KnobModel {
    /// The model of a fit; `None` until a parameter is identified.
    pub fn from_fit(fit: &FitUpdate) -> Option<Self> {
        let estimates = fit.estimates();
        Self::from_estimates(|name| {
            let (_, estimate) = estimates.iter().find(|(known, _)| *known == name)?;
            Some([finite_value(estimate)?, estimate.half_width()])
        })
    }

    /// The model of the parameters that have a value, and half of its 95 % interval, by their standard names; `None` if none
    /// has.
    pub fn from_estimates(estimate: impl Fn(&str) -> Option<[f64; 2]>) -> Option<Self> {
        parameters().find(|parameter| estimate(parameter.name).is_some())?;
        let missing = |name: &str| if name == "inertia" || name.starts_with("viscous_") { 0.0 } else { f64::NAN };
        let mut model = equation_one(|name| estimate(name).map_or(missing(name), |[value, _]| value));
        let is_identified = |detent: &Effect| detent.values().iter().all(|value| value.is_finite());
        model.effects.retain(|effect| {
            effect.kind().name != detent::KIND.name || is_identified(effect) && effect.values()[1] != 0.0
        });
        let half_width = |name: &str| estimate(name).map(|[_, half_width]| half_width).filter(|half| half.is_finite());
        Some(Self { model, half_widths: equation_one(|name| half_width(name).unwrap_or(0.0)), ..Self::default() })
    }

    /// The model with what a fit measured over the angle, and the half width of its 95 % interval, mNm.
    pub fn with_characteristic(mut self, effects: &[Effect], characteristic_half_width_mnm: f64) -> Self {
        self.model.effects.extend(effects.iter().filter(|effect| effect.table().is_some()));
        Self { characteristic_half_width_mnm, ..self }
    }

    /// The model as the rig's torque sensor reads it, with the gripper and the sensor's zero; as it is without a calibration.
    pub fn on_rig(mut self, calibration: Option<&Calibration>) -> Self {
        if let Some(known) = calibration {
            self.model.effects.push(Effect::new(&inertia::KIND, &[known.gripper_inertia]));
            self.zero_mnm += known.torque_zero_mnm;
        }
        self
    }

    /// The whole torque, mNm, at an angle, rad, a velocity, rad/s, and an acceleration, rad/s²; without friction at rest,
    /// NaN where that is not identified.
    pub fn torque_mnm(&self, angle_rad: f64, velocity_rad_s: f64, acceleration_rad_s2: f64) -> f64 {
        let motion = Motion { angle_rad, velocity_rad_s, acceleration_rad_s2, ..Motion::default() };
        self.zero_mnm + self.model.torque_mnm(&motion)
    }

    /// Least and largest torque over all angles while turning at this velocity, in addition to zero and friction, mNm; `None` where
    /// the torque does not depend on the angle.
    pub fn range_over_angle_mnm(&self, velocity_rad_s: f64) -> Option<Extent> {
        let measured = || self.model.effects.iter().filter(|effect| effect.table().is_some());
        let Some(table) = measured().find_map(Effect::table) else {
            return self.detent().map(|[amplitude, ..]| [-amplitude.abs(), amplitude.abs()]);
        };
        let direction = Direction::of(velocity_rad_s);
        let torque_mnm = |angle_rad: &f64| -> f64 {
            let motion = Motion { angle_rad: *angle_rad, velocity_rad_s, ..Motion::default() };
            measured().map(|effect| effect.free_torque_mnm(&motion) + effect.friction_mnm(&motion, direction)).sum()
        };
        extent::of(table.points().iter().map(torque_mnm))
    }

    /// Coulomb and viscous friction while turning, with the sensor's zero, mNm; NaN where it is not identified.
    pub fn friction_mnm(&self, velocity_rad_s: f64) -> f64 {
        let motion = Motion { velocity_rad_s, ..Motion::default() };
        let friction = self.model.effect(friction::KIND.name);
        self.zero_mnm + friction.map_or(0.0, |friction| friction.friction_mnm(&motion, Direction::of(velocity_rad_s)))
    }

    /// Amplitude, mNm, period, rad, and phase, rad, of the detents, once all are identified.
    pub fn detent(&self) -> Option<[f64; 3]> {
        self.model.effect(detent::KIND.name)?.values().try_into().ok()
    }

    /// Half of the 95 % interval of a parameter, in its unit.
    fn half_width(&self, name: &str) -> f64 {
        self.half_widths.parameter(name).unwrap_or(0.0)
    }

    /// Half of the 95 % interval of the friction torque, mNm.
    pub fn friction_half_width_mnm(&self, velocity_rad_s: f64) -> f64 {
        let direction = if velocity_rad_s < 0.0 { "negative" } else { "positive" };
        let [coulomb, viscous] = ["coulomb", "viscous"].map(|kind| self.half_width(&format!("{kind}_{direction}")));
        coulomb.hypot(viscous * velocity_rad_s)
    }

    /// Half of the 95 % interval of friction and all that depends on the angle together, mNm.
    pub fn half_width_mnm(&self, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        let detent = self.detent().map_or(0.0, |[amplitude, period, phase]| {
            let (sine, cosine) = (angle_rad / period + phase).sin_cos();
            let of_phase = amplitude * cosine * self.half_width("detent_phase");
            let of_period = amplitude * cosine * angle_rad / (period * period) * self.half_width("detent_period");
            (sine * self.half_width("detent_amplitude")).hypot(of_phase).hypot(of_period)
        });
        self.friction_half_width_mnm(velocity_rad_s).hypot(detent).hypot(self.characteristic_half_width_mnm)
    }
}

/// Inertia, friction and detents with a number for each parameter, by its standard name.
fn equation_one(number: impl Fn(&str) -> f64) -> Model {
    let effect = |kind: &'static EffectKind| {
        let numbers: Vec<f64> = kind.parameters.iter().map(|parameter| number(parameter.name)).collect();
        Effect::new(kind, &numbers)
    };
    Model { effects: EQUATION_ONE.map(effect).into(), ..Model::default() }
}

/// The value of a parameter that the data can tell.
pub fn finite_value(estimate: &Estimate) -> Option<f64> {
    (Verdict::from_code(estimate.verdict) == Some(Verdict::Estimated) && estimate.value.is_finite())
        .then_some(estimate.value)
}

#[cfg(test)]
pub(crate) mod tests {
    use shared_types::Convergence;

    use super::*;

    pub(crate) fn calibration() -> Calibration {
        let known = "gripper_inertia = 0.004\nmotor_inertia = 0.016\ntorque_sensor_stiffness_mnm_rad = 5e5\n\
                     torque_zero_mnm = 0.6\ntorque_delay_s = 0.0\nacceleration_zero_rad_s2 = 0.0\n\
                     acceleration_delay_s = 0.0\ngravity_amplitude_rad_s2 = 0.0\ngravity_phase_rad = 0.0\n\
                     angle_step_rad = 1e-5\ntorque_step_mnm = 0.18\nacceleration_step_rad_s2 = 2.8\n";
        Calibration::from_toml(known).unwrap()
    }

    /// A parameter that is known with that half width.
    pub(crate) fn estimated(value: f64, half_width: f64, convergence: Convergence) -> Estimate {
        let (ci95_low, ci95_high) = (value - half_width, value + half_width);
        let (verdict, convergence) = (Verdict::Estimated.code(), convergence.code());
        Estimate { value, ci95_low, ci95_high, verdict, convergence }
    }

    #[test]
    fn the_torque_of_knob_three_is_equation_one_worked_by_hand() {
        let knob = dynamics::knobs::paper_knob(3).unwrap();
        let model = KnobModel::from_estimates(|name| Some([knob.parameter(name)?, 0.0])).unwrap();
        // 0.035·100 + 2.3 − 0.24·2 + 1.1·sin(0.1/0.034 + 0.16) = 5.32 + 1.1·sin(3.101176)
        assert!((model.torque_mnm(0.1, 2.0, 100.0) - 5.364_445).abs() < 1e-5);
        // −2.3 + (−0.15)(−2) + 1.1·sin(0.16)
        assert!((model.torque_mnm(0.0, -2.0, 0.0) - -1.824_750).abs() < 1e-5);
        assert_eq!(model.torque_mnm(0.0, 0.0, 0.0), 1.1 * 0.16_f64.sin(), "no friction at rest");
        let more_mnm =
            model.clone().on_rig(Some(&calibration())).torque_mnm(0.1, 2.0, 100.0) - model.torque_mnm(0.1, 2.0, 100.0);
        assert!((more_mnm - (0.6 + 0.4)).abs() < 1e-12, "the sensor also bears the gripper and has its zero");
    }

    #[test]
    fn a_term_that_is_not_identified_is_left_out_and_without_its_friction_a_direction_has_no_torque() {
        let known = |value| estimated(value, 0.0, Convergence::Converged);
        let fit = FitUpdate {
            inertia: known(f64::NAN),
            coulomb_negative: Estimate { verdict: Verdict::NotYet.code(), ..known(2.3) },
            coulomb_positive: known(2.3),
            viscous_negative: known(-0.15),
            viscous_positive: known(-0.24),
            detent_amplitude: known(1.1),
            detent_period: Estimate { verdict: Verdict::NotYet.code(), ..known(0.034) },
            detent_phase: known(0.16),
            ..FitUpdate::default()
        };
        let model = KnobModel::from_fit(&fit).unwrap();
        assert_eq!(model.torque_mnm(0.1, 1.0, 1_000.0), 2.3 - 0.24);
        assert!(model.torque_mnm(0.1, -2.0, 100.0).is_nan());
        assert_eq!(model.detent(), None);
        assert_eq!(KnobModel::from_fit(&FitUpdate::default()), None);
    }

    #[test]
    fn what_is_not_known_better_moves_the_torque_by_its_derivative() {
        let detent = [1.1, 0.034, 0.16];
        let names = ["detent_amplitude", "detent_period", "detent_phase"];
        let value = |name: &str| names.iter().position(|known| *known == name).map_or(0.0, |place| detent[place]);
        let only = |known: &'static str, half_width: f64| {
            KnobModel::from_estimates(|name| Some([value(name), if name == known { half_width } else { 0.0 }])).unwrap()
        };
        let near =
            |value: f64, expected: f64| assert!((value - expected).abs() < 1e-3 * expected, "{value} {expected}");
        near(only("coulomb_negative", 0.2).friction_half_width_mnm(-3.0), 0.2);
        near(only("viscous_positive", 0.02).friction_half_width_mnm(3.0), 0.06);
        assert_eq!(only("viscous_positive", 0.02).friction_half_width_mnm(-3.0), 0.0);
        // Against differences of the torque itself.
        let torque = |[amplitude, period, phase]: [f64; 3]| amplitude * (0.21_f64 / period + phase).sin();
        for (index, name) in names.into_iter().enumerate() {
            let mut moved = detent;
            moved[index] += 1e-7;
            near(only(name, 1e-7).half_width_mnm(0.21, 0.0), (torque(moved) - torque(detent)).abs());
        }
    }
}
