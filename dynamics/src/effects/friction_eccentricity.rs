//! Coulomb friction that varies over a turn.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role};

/// `friction-eccentricity`: Coulomb friction times 1 + e·cos(θ + ε), as when a shaft runs out of true.
pub static KIND: EffectKind = EffectKind {
    name: "friction-eccentricity",
    description: "Coulomb friction varies with the angle, once per turn",
    source: "a bearing whose preload varies with the run-out of its shaft",
    role: Role::Friction,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "eccentricity_depth",
            unit: "1",
            symbol: "e",
            description: "largest relative change of the Coulomb friction",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "eccentricity_phase",
            unit: "rad",
            symbol: "ε",
            description: "phase at angle zero",
            minimum: Minimum::None,
        },
    ],
    part: Part::CoulombFactor(|values, motion| values[0] * (motion.angle_rad + values[1]).cos()),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 2,
        searched: &[],
        // e·cos(θ + ε) = e·cos ε·cos θ − e·sin ε·sin θ
        fill: |_, motion, row| (row[1], row[0]) = motion.angle_rad.sin_cos(),
        values: |coefficients, values| {
            values[0] = coefficients[0].hypot(coefficients[1]);
            values[1] = (-coefficients[1]).atan2(coefficients[0]);
        },
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis { searched: &[], least_turn_rad: Some(0.5), ..Hypothesis::PLAIN }),
};
