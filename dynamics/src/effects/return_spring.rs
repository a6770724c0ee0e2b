//! A spring that pulls towards an angle.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role};

/// `return-spring`: τ = K·(θ − θ₀).
pub static KIND: EffectKind = EffectKind {
    name: "return-spring",
    description: "torque in proportion to the distance from a centre",
    source: "Hooke",
    role: Role::Other,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "spring_stiffness",
            unit: "mNm/rad",
            symbol: "K",
            description: "stiffness",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "spring_centre",
            unit: "rad",
            symbol: "θ₀",
            description: "angle at which the spring is at rest",
            minimum: Minimum::None,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * (motion.angle_rad - values[1])),
    steepest_mnm_rad: Some(|effect| effect.values()[0]),
    regressors: Some(Regressors {
        columns: 2,
        searched: &[],
        fill: |_, motion, row| (row[0], row[1]) = (motion.angle_rad, -1.0),
        values: |coefficients, values| {
            values[0] = coefficients[0];
            values[1] = if coefficients[0] > 0.0 { coefficients[1] / coefficients[0] } else { 0.0 };
        },
        nonnegative: &[0],
    }),
    hypothesis: Some(Hypothesis::PLAIN),
};
