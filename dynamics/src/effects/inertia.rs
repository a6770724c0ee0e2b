//! Inertia: torque in proportion to acceleration.

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `inertia`: τ = M·θ̈.
pub static KIND: EffectKind = EffectKind {
    name: "inertia",
    description: "torque in proportion to acceleration",
    source: "Swindells and MacLean 2007, equation 1, top row",
    role: Role::Inertia,
    depends_on: &[Coordinate::Acceleration],
    parameters: &[ParameterKind {
        name: "inertia",
        unit: "mNm s²/rad",
        symbol: "M",
        description: "moment of inertia",
        minimum: Minimum::Zero,
    }],
    part: Part::Inertia(|values| values[0]),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[],
        fill: |_, motion, row| row[0] = motion.acceleration_rad_s2,
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: None,
};
