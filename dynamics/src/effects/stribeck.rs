//! Friction that rises towards zero speed.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, Regressors, Role, Search};

/// `stribeck`: sliding friction is larger by F·exp(−(|θ̇|/v)^δ).
pub static KIND: EffectKind = EffectKind {
    name: "stribeck",
    description: "friction rises towards zero speed by an amount that decays with a characteristic speed",
    source: "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30 (1994) 1083–1138",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "stribeck_torque",
            unit: "mNm",
            symbol: "F",
            description: "friction at zero speed beyond the Coulomb friction",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "stribeck_speed",
            unit: "rad/s",
            symbol: "v",
            description: "speed over which it decays",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "stribeck_exponent",
            unit: "1",
            symbol: "δ",
            description: "how sharply it decays",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::Friction(|values, motion, direction| direction.sign() * values[0] * decay(values, motion)),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1, 2],
        fill: |effect, motion, row| {
            row[0] = motion.velocity_sign() * decay(effect.values(), motion);
        },
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[0],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[
            Search {
                parameter: 1,
                range: |scene| Some((0.02 * scene.median_speed_rad_s, scene.highest_speed_rad_s)),
                starts: |_| 6,
                logarithmic: true,
                is_coulomb_at_least: true,
                ..Search::PLAIN
            },
            Search { parameter: 2, range: |_| Some((0.5, 2.5)), starts: |_| 2, ..Search::PLAIN },
        ],
        ..Hypothesis::PLAIN
    }),
};

fn decay(values: &[f64], motion: &Motion) -> f64 {
    (-(motion.velocity_rad_s.abs() / values[1]).powf(values[2])).exp()
}
