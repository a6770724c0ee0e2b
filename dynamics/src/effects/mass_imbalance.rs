//! Gravity on an off-centre mass.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role};

/// `mass-imbalance`: τ = G·sin(θ + γ), once per turn.
pub static KIND: EffectKind = EffectKind {
    name: "mass-imbalance",
    description: "gravity on a mass off the axis: a sinusoid of the angle, once per turn",
    source: "statics: m·g·r·sin of the angle from the vertical",
    role: Role::Other,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "imbalance_torque",
            unit: "mNm",
            symbol: "G",
            description: "largest torque of gravity",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "imbalance_phase",
            unit: "rad",
            symbol: "γ",
            description: "phase at angle zero",
            minimum: Minimum::None,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * (motion.angle_rad + values[1]).sin()),
    steepest_mnm_rad: Some(|effect| effect.values()[0].abs()),
    regressors: Some(Regressors {
        columns: 2,
        searched: &[],
        fill: |_, motion, row| (row[0], row[1]) = motion.angle_rad.sin_cos(),
        values: |coefficients, values| {
            values[0] = coefficients[0].hypot(coefficients[1]);
            values[1] = coefficients[1].atan2(coefficients[0]);
        },
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis { searched: &[], least_turn_rad: Some(0.5), ..Hypothesis::PLAIN }),
};
