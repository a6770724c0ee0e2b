//! Detents: a torque that repeats with the angle.

use std::f64::consts::{PI, TAU};

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `detent`: τ = A·sin(θ/P + S). The spatial period, from one detent to the next, is 2πP.
pub static KIND: EffectKind = EffectKind {
    name: "detent",
    description: "a sinusoidal torque of the angle",
    source: "Swindells and MacLean 2007, equation 1, bottom row",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "detent_amplitude",
            unit: "mNm",
            symbol: "A",
            description: "largest detent torque",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "detent_period",
            unit: "rad",
            symbol: "P",
            description: "angle per radian of the detent sine; detents are 2πP apart",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "detent_phase",
            unit: "rad",
            symbol: "S",
            description: "phase of the detent sine at angle zero",
            minimum: Minimum::None,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * (motion.angle_rad / values[1] + values[2]).sin()),
    steepest_mnm_rad: Some(|effect| (effect.values()[0] / effect.values()[1]).abs()),
    regressors: Some(Regressors {
        columns: 2,
        searched: &[1],
        // A·sin(θ/P + S) = A·cos S·sin(θ/P) + A·sin S·cos(θ/P)
        fill: |effect, motion, row| {
            let (sine, cosine) = (motion.angle_rad / effect.values()[1]).sin_cos();
            row[0] = sine;
            row[1] = cosine;
        },
        values: |coefficients, values| {
            values[0] = coefficients[0].hypot(coefficients[1]);
            values[2] = coefficients[1].atan2(coefficients[0]);
        },
        nonnegative: &[],
    }),
    hypothesis: None,
};

/// The same detent written with a positive amplitude and a phase in (−π, π].
///
/// Takes and returns (amplitude in mNm, phase in rad): −A·sin(x + S) is A·sin(x + S + π).
#[must_use]
pub fn canonical(amplitude_mnm: f64, phase_rad: f64) -> (f64, f64) {
    let phase = if amplitude_mnm < 0.0 { phase_rad + PI } else { phase_rad };
    let wrapped = phase - TAU * ((phase - PI) / TAU).ceil();
    (amplitude_mnm.abs(), wrapped)
}
