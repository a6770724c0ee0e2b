//! A torque that rises from one angle to another and then stays.

use crate::{Coordinate, EffectKind, Minimum, Motion, ParameterKind, Part, Regressors, Role};

/// `torque-ramp`: τ = T·clamp((θ − θ₁)/w, 0, 1): nothing before θ₁, all of T beyond θ₁ + w.
pub static KIND: EffectKind = EffectKind {
    name: "torque-ramp",
    description: "a torque that rises in a straight line between two angles",
    source: "a straight line",
    role: Role::Other,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "ramp_torque",
            unit: "mNm",
            symbol: "T",
            description: "torque beyond the ramp",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "ramp_start",
            unit: "rad",
            symbol: "θ₁",
            description: "angle at which the torque begins to rise",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "ramp_width",
            unit: "rad",
            symbol: "w",
            description: "angle over which it rises",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * risen(values, motion)),
    steepest_mnm_rad: Some(|effect| (effect.values()[0] / effect.values()[2]).abs()),
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1, 2],
        fill: |effect, motion, row| row[0] = risen(effect.values(), motion),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: None,
};

/// How much of the ramp lies behind, 0 to 1.
fn risen(values: &[f64], motion: &Motion) -> f64 {
    ((motion.angle_rad - values[1]) / values[2]).clamp(0.0, 1.0)
}
