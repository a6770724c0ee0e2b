//! A dome that snaps through.

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `snap-through`: τ = T·(3√3/2)·ξ(ξ − 1)(ξ − 2) with ξ = θ/θ_f between 0 and 2, nothing beyond.
///
/// The shallow truss of two bars that is pressed flat at θ_f: its force rises to T at 0.42 θ_f, falls through zero where it is flat, and pulls
/// along from there to 2 θ_f. With a `return-spring` beside it, it is a rubber dome: collapse and valley are the extremes of the
/// sum.
pub static KIND: EffectKind = EffectKind {
    name: "snap-through",
    description: "a dome gives way as it is pressed, and snaps back",
    source: "shallow truss of von Mises (R. von Mises, Z. angew. Math. Mech. 3, 1923, 406–422)",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "snap_height",
            unit: "mNm",
            symbol: "T",
            description: "largest torque of the truss alone",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "snap_flat_angle",
            unit: "rad",
            symbol: "θ_f",
            description: "angle at which the truss is flat",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * share(values, motion.angle_rad)),
    // At both ends of its way ξ(ξ − 1)(ξ − 2) rises by 2.
    steepest_mnm_rad: Some(|effect| effect.values()[0] * 2.0 * HEIGHT / effect.values()[1]),
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1],
        fill: |effect, motion, row| row[0] = share(effect.values(), motion.angle_rad),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[0],
    }),
    // A diagnosis of a pressed control measures the curve over the travel, which includes this.
    hypothesis: None,
};

/// 3√3/2: makes the extremes of ξ(ξ − 1)(ξ − 2), 2/(3√3), one.
const HEIGHT: f64 = 2.598_076_211_353_316;

fn share(values: &[f64], angle_rad: f64) -> f64 {
    let place = angle_rad / values[1];
    if (0.0..2.0).contains(&place) { HEIGHT * place * (place - 1.0) * (place - 2.0) } else { 0.0 }
}
