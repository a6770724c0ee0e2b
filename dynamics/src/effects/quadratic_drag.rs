//! Drag of a fluid that is thrown about.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role};

/// `quadratic-drag`: τ = Q·θ̇·|θ̇|.
pub static KIND: EffectKind = EffectKind {
    name: "quadratic-drag",
    description: "torque in proportion to speed times its magnitude",
    source: "drag at high Reynolds number",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity],
    parameters: &[ParameterKind {
        name: "drag_coefficient",
        unit: "mNm s²/rad²",
        symbol: "Q",
        description: "torque per squared speed",
        minimum: Minimum::Zero,
    }],
    part: Part::Torque(|values, motion| values[0] * motion.velocity_rad_s * motion.velocity_rad_s.abs()),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[],
        fill: |_, motion, row| row[0] = motion.velocity_rad_s * motion.velocity_rad_s.abs(),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[0],
    }),
    hypothesis: Some(Hypothesis::PLAIN),
};
