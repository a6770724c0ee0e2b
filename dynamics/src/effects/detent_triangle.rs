//! Detents whose torque goes up and down in straight lines.

use std::f64::consts::{FRAC_2_PI, PI, TAU};

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Regressors, Role};

/// `detent-triangle`: τ = A·tri(θ/P + S), tri the triangle wave with zeros and extremes where the sine has them.
pub static KIND: EffectKind = EffectKind {
    name: "detent-triangle",
    description: "detents whose torque rises and falls in straight lines",
    source: "triangle wave; amplitude, period and phase as in equation 1 of Swindells and MacLean 2007",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "triangle_amplitude",
            unit: "mNm",
            symbol: "A",
            description: "largest torque",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "triangle_period",
            unit: "rad",
            symbol: "P",
            description: "angle per radian of the wave; detents are 2πP apart",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "triangle_phase",
            unit: "rad",
            symbol: "S",
            description: "phase of the wave at angle zero",
            minimum: Minimum::None,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * wave(motion.angle_rad / values[1] + values[2])),
    steepest_mnm_rad: Some(|effect| FRAC_2_PI * (effect.values()[0] / effect.values()[1]).abs()),
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1, 2],
        fill: |effect, motion, row| row[0] = wave(motion.angle_rad / effect.values()[1] + effect.values()[2]),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: None,
};

/// 0 at 0, 1 at π/2, −1 at 3π/2, in straight lines.
fn wave(phase_rad: f64) -> f64 {
    // Counted from the wave's lowest point; the upper half mirrors the lower.
    let from_lowest = (phase_rad + 0.5 * PI).rem_euclid(TAU);
    1.0 - FRAC_2_PI * (from_lowest - PI).abs()
}
