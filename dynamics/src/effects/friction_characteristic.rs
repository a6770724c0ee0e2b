//! Friction measured over the angle that has no name.

use crate::{Coordinate, Curve, EffectKind, Minimum, ParameterKind, Part, Regressors, Role, TableUse};

/// `friction-characteristic`: τ = k·sgn(θ̇)·table(θ), held beyond the first and the last point unless there is a period.
///
/// Half the difference of both directions, beyond the friction that has a name: a scratch, a dry spot.
pub static KIND: EffectKind = EffectKind {
    name: "friction-characteristic",
    description: "friction measured over the angle, without a name",
    source: "half the difference of rising and falling branch; between the points a cubic",
    role: Role::Friction,
    depends_on: &[Coordinate::Angle],
    parameters: &[ParameterKind {
        name: "friction_characteristic_scale",
        unit: "1",
        symbol: "k",
        description: "factor on the table's torque",
        minimum: Minimum::None,
    }],
    part: Part::FrictionTable(TableUse { curve: Curve::Spline, over: Coordinate::Angle, holds: true }),
    steepest_mnm_rad: None,
    regressors: Some(Regressors::OF_TABLE),
    hypothesis: None,
};
