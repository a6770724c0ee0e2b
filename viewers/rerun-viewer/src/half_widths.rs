//! How sure the model's torque is: the parameters' intervals carried over to the torque.
//!
//! Each parameter's half width h moves the torque by h·∂τ/∂p; the parts are added as independent ones, by their
//! squares. The live fitter does not publish how the parameters' errors hang together, so this is an approximation:
//! where errors make up for each other, as those of Coulomb and viscous friction mostly do, it is too wide.

/// Half of the 95 % interval of each parameter, in the parameter's unit; 0 for what the model does not have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HalfWidths {
    coulomb_negative: f64,
    coulomb_positive: f64,
    viscous_negative: f64,
    viscous_positive: f64,
    detent_amplitude: f64,
    detent_period: f64,
    detent_phase: f64,
    characteristic_mnm: f64,
}

impl HalfWidths {
    /// From the half widths of the parameters that have one, by their standard names.
    pub fn from_values(value_of: impl Fn(&str) -> Option<f64>) -> Self {
        let or_zero = |name| value_of(name).filter(|half_width| half_width.is_finite()).unwrap_or(0.0);
        Self {
            coulomb_negative: or_zero("coulomb_negative"),
            coulomb_positive: or_zero("coulomb_positive"),
            viscous_negative: or_zero("viscous_negative"),
            viscous_positive: or_zero("viscous_positive"),
            detent_amplitude: or_zero("detent_amplitude"),
            detent_period: or_zero("detent_period"),
            detent_phase: or_zero("detent_phase"),
            characteristic_mnm: 0.0,
        }
    }

    /// With that of a torque measured over the angle, mNm.
    pub fn with_characteristic(self, half_width_mnm: f64) -> Self {
        Self { characteristic_mnm: half_width_mnm, ..self }
    }

    /// Of the torque measured over the angle, mNm.
    pub fn characteristic_mnm(&self) -> f64 {
        self.characteristic_mnm
    }

    /// Of the friction torque, mNm.
    pub fn friction_mnm(&self, velocity_rad_s: f64) -> f64 {
        let (coulomb, viscous) = if velocity_rad_s < 0.0 {
            (self.coulomb_negative, self.viscous_negative)
        } else {
            (self.coulomb_positive, self.viscous_positive)
        };
        coulomb.hypot(viscous * velocity_rad_s)
    }

    /// Of the detents' torque, mNm, for detents of this amplitude, period and phase.
    pub fn detent_mnm(&self, [amplitude, period, phase]: [f64; 3], angle_rad: f64) -> f64 {
        let (sine, cosine) = (angle_rad / period + phase).sin_cos();
        let of_phase = amplitude * cosine * self.detent_phase;
        let of_period = amplitude * cosine * angle_rad / (period * period) * self.detent_period;
        (sine * self.detent_amplitude).hypot(of_phase).hypot(of_period)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_known_better_moves_the_torque_by_its_derivative() {
        let only = |known: &'static str, half_width: f64| {
            HalfWidths::from_values(move |name| (name == known).then_some(half_width))
        };
        let near =
            |value: f64, expected: f64| assert!((value - expected).abs() < 1e-3 * expected, "{value} {expected}");
        near(only("coulomb_negative", 0.2).friction_mnm(-3.0), 0.2);
        near(only("viscous_positive", 0.02).friction_mnm(3.0), 0.06);
        assert_eq!(only("viscous_positive", 0.02).friction_mnm(-3.0), 0.0);
        // Against differences of the torque itself.
        let torque = |[amplitude, period, phase]: [f64; 3]| amplitude * (0.21_f64 / period + phase).sin();
        let detent = [1.1, 0.034, 0.16];
        for (index, name) in ["detent_amplitude", "detent_period", "detent_phase"].into_iter().enumerate() {
            let mut moved = detent;
            moved[index] += 1e-7;
            near(only(name, 1e-7).detent_mnm(detent, 0.21), (torque(moved) - torque(detent)).abs());
        }
    }
}
