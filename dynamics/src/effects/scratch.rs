//! Friction over a part of the travel only.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role, Search};

/// `scratch`: Coulomb friction larger by F between two angles; smaller where F is negative.
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
            name: "scratch_begin",
            unit: "rad",
            symbol: "θ₁",
            description: "angle at which it begins",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "scratch_end",
            unit: "rad",
            symbol: "θ₂",
            description: "angle at which it ends",
            minimum: Minimum::None,
        },
    ],
    part: Part::Friction(|values, motion, direction| direction.sign() * values[0] * depth(values, motion.angle_rad)),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1, 2],
        fill: |effect, motion, row| {
            row[0] = motion.velocity_sign() * depth(effect.values(), motion.angle_rad);
        },
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis { searched: &[edge(1), edge(2)], ..Hypothesis::PLAIN }),
};

/// The search for an edge: both must lie within the travel, or it is no part of it.
const fn edge(parameter: usize) -> Search {
    Search {
        parameter,
        range: |scene| {
            let margin_rad = 0.05 * scene.travel_rad();
            Some((scene.lowest_rad + margin_rad, scene.highest_rad - margin_rad))
        },
        starts: |_| 20,
        ..Search::PLAIN
    }
}

/// 1 within the scratch, 0 beyond, a smooth step between.
fn depth(values: &[f64], angle_rad: f64) -> f64 {
    let width_rad = values[2] - values[1];
    if width_rad <= 0.0 {
        return 0.0;
    }
    let inside = (angle_rad - values[1]).min(values[2] - angle_rad) / width_rad;
    let rise = (7.0 * inside + 0.5).clamp(0.0, 1.0);
    rise * rise * (3.0 - 2.0 * rise)
}
