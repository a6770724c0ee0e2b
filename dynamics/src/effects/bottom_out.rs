//! The end of a pressed control's travel.

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `bottom-out`: τ = K·(θ − θ_b) beyond θ_b, nothing before it.
///
/// Softer than an `end-stop`, and without its damping: a dome of rubber pressed flat, a plunger on its seat.
pub static KIND: EffectKind = EffectKind {
    name: "bottom-out",
    description: "a pressed control meets the end of its travel",
    source: "one-sided contact of Hertz's kind made linear; sheets quote its place as travel, its slope as stiffness",
    role: Role::Other,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "bottom_stiffness",
            unit: "mNm/rad",
            symbol: "K",
            description: "stiffness beyond the bottom",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "bottom_angle",
            unit: "rad",
            symbol: "θ_b",
            description: "angle at which the bottom is met",
            minimum: Minimum::None,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * depth(values, motion.angle_rad)),
    steepest_mnm_rad: Some(|effect| effect.values()[0]),
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1],
        fill: |effect, motion, row| row[0] = depth(effect.values(), motion.angle_rad),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[0],
    }),
    // A diagnosis of a pressed control measures the curve over the travel, which includes this.
    hypothesis: None,
};

fn depth(values: &[f64], angle_rad: f64) -> f64 {
    (angle_rad - values[1]).max(0.0)
}
