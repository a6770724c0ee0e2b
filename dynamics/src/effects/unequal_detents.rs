//! Detents of which each has its own place and height.

use crate::{Coordinate, Curve, EffectKind, Minimum, ParameterKind, Part, Regressors, Role, TableUse, TorqueTable};

/// `unequal-detents`: τ = k·table(θ), quarter sines between zeros and extremes.
///
/// The points alternate: a torque of zero, where the knob rests or is about to fall into the next detent, and an extreme
/// half way between two zeros. It stands in the place of `detent`.
pub static KIND: EffectKind = EffectKind {
    name: "unequal-detents",
    description: "detents that differ in pitch and height",
    source: "indexing mechanisms are made to ±3° and ±30 % (data sheets of rotary encoders with detents)",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[ParameterKind {
        name: "unequal_scale",
        unit: "1",
        symbol: "k",
        description: "factor on the table's torque",
        minimum: Minimum::None,
    }],
    part: Part::TorqueTable(TableUse { curve: Curve::Sine, over: Coordinate::Angle, holds: false }),
    steepest_mnm_rad: Some(|effect| {
        effect.values()[0].abs() * effect.table().map_or(0.0, TorqueTable::steepest_mnm_rad)
    }),
    regressors: Some(Regressors::OF_TABLE),
    hypothesis: None,
};
