//! A torque drawn as a table over the angle.

use crate::{Coordinate, Curve, EffectKind, Minimum, ParameterKind, Part, Regressors, Role, TableUse, TorqueTable};

/// `torque-table`: τ = k·table(θ), the table repeating along the angle ([`TorqueTable`]).
///
/// In a model file the table itself stands beside the parameter: `angle_rad`, `torque_mnm` and, unless the last point
/// repeats the first, `period_rad`. A file that leaves the scale out has the table as drawn.
pub static KIND: EffectKind = EffectKind {
    name: "torque-table",
    description: "a torque drawn over the angle, repeating",
    source: "drawn by hand, or read off a knob; between the points a monotone cubic of Fritsch and Butland",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[ParameterKind {
        name: "table_scale",
        unit: "1",
        symbol: "k",
        description: "factor on the drawn torque",
        minimum: Minimum::None,
    }],
    part: Part::TorqueTable(TableUse { curve: Curve::Cubic, over: Coordinate::Angle, holds: false }),
    steepest_mnm_rad: Some(|effect| {
        effect.values()[0].abs() * effect.table().map_or(0.0, TorqueTable::steepest_mnm_rad)
    }),
    regressors: Some(Regressors::OF_TABLE),
    hypothesis: None,
};
