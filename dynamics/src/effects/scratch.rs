//! Friction over a part of the travel only.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role, Search};

/// `scratch`: Coulomb friction larger by F within w of an angle, either way half of it; smaller where F is negative.
pub static KIND: EffectKind = EffectKind {
    name: "scratch",
    description: "friction differs over a part of the travel",
    source: "a scratch, a burr, a dry or a greasy spot; edges a seventh of the width",
    role: Role::Friction,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "scratch_friction",
            unit: "mNm",
            symbol: "F",
            description: "friction there beyond the friction elsewhere",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "scratch_centre",
            unit: "rad",
            symbol: "θₛ",
            description: "angle of its middle",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "scratch_width",
            unit: "rad",
            symbol: "w",
            description: "angle over which it lies",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::Friction(|values, motion, direction| direction.sign() * values[0] * depth(values, motion.angle_rad)),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1, 2],
        fill: |effect, motion, row| {
            let sign = if motion.velocity_rad_s == 0.0 { 0.0 } else { motion.velocity_rad_s.signum() };
            row[0] = sign * depth(effect.values(), motion.angle_rad);
        },
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[
            Search {
                parameter: 1,
                range: |scene| Some((scene.lowest_rad, scene.highest_rad)),
                starts: |_| 32,
                logarithmic: false,
                same_as: None,
            },
            Search {
                parameter: 2,
                // What is wider than a third of the travel is no part of it.
                range: |scene| Some((0.02 * scene.travel_rad(), 0.35 * scene.travel_rad())),
                starts: |_| 4,
                logarithmic: true,
                same_as: None,
            },
        ],
        nested: &[],
        least_travel_rad: 0.0,
        per_capture: false,
    }),
};

/// 1 within the scratch, 0 beyond, a smooth step between.
fn depth(values: &[f64], angle_rad: f64) -> f64 {
    let inside = 0.5 - (angle_rad - values[1]).abs() / values[2];
    let rise = (7.0 * inside + 0.5).clamp(0.0, 1.0);
    rise * rise * (3.0 - 2.0 * rise)
}
