//! A torque sensor that reads a constant too much.

use crate::{EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role};

/// `torque-offset`: the reading is the torque plus O.
///
/// Coulomb friction of two levels can stand in for it as long as neither level would have to be negative.
pub static KIND: EffectKind = EffectKind {
    name: "torque-offset",
    description: "the torque sensor reads a constant too much",
    source: "zero drift of a strain-gauge bridge",
    role: Role::Other,
    depends_on: &[],
    parameters: &[ParameterKind {
        name: "torque_offset",
        unit: "mNm",
        symbol: "O",
        description: "reading without any torque",
        minimum: Minimum::None,
    }],
    part: Part::Reading(|values, _| values[0]),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[],
        fill: |_, _, row| row[0] = 1.0,
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis::PLAIN),
};
