//! Friction measured over the speed that has no name.

use crate::{Coordinate, Curve, EffectKind, Minimum, ParameterKind, Part, Regressors, Role, TableUse};

/// `speed-characteristic`: τ = k·sgn(θ̇)·table(|θ̇|), held beyond the first and the last point.
///
/// What is measured beyond the friction that has a name.
pub static KIND: EffectKind = EffectKind {
    name: "speed-characteristic",
    description: "friction measured over the speed, without a name",
    source: "mean torque against the direction of turning; between the points a cubic",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity],
    parameters: &[ParameterKind {
        name: "speed_characteristic_scale",
        unit: "1",
        symbol: "k",
        description: "factor on the table's torque",
        minimum: Minimum::None,
    }],
    part: Part::FrictionTable(TableUse { curve: Curve::Spline, over: Coordinate::Velocity, holds: true }),
    steepest_mnm_rad: None,
    regressors: Some(Regressors::OF_TABLE),
    hypothesis: None,
};
