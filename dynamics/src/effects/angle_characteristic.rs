//! A torque measured over the angle that has no name.

use crate::{Coordinate, Curve, EffectKind, Minimum, ParameterKind, Part, Regressors, Role, TableUse, TorqueTable};

/// `angle-characteristic`: τ = k·table(θ), held beyond the first and the last point unless there is a period.
///
/// What the mean of both directions shows beyond the effects that have a name.
pub static KIND: EffectKind = EffectKind {
    name: "angle-characteristic",
    description: "a torque measured over the angle, without a name",
    source: "mean of rising and falling branch; between the points a cubic",
    role: Role::Other,
    depends_on: &[Coordinate::Angle],
    parameters: &[ParameterKind {
        name: "angle_characteristic_scale",
        unit: "1",
        symbol: "k",
        description: "factor on the table's torque",
        minimum: Minimum::None,
    }],
    part: Part::TorqueTable(TableUse { curve: Curve::Spline, over: Coordinate::Angle, holds: true }),
    steepest_mnm_rad: Some(|effect| {
        effect.values()[0].abs() * effect.table().map_or(0.0, TorqueTable::steepest_mnm_rad)
    }),
    regressors: Some(Regressors::OF_TABLE),
    hypothesis: None,
};
