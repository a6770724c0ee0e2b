//! Friction that rises from near zero speed.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, Regressors, Role, Search};

/// `velocity-strengthening`: sliding friction is larger by F·(1 − exp(−|θ̇|/v)).
pub static KIND: EffectKind = EffectKind {
    name: "velocity-strengthening",
    description: "friction rises from zero speed by an amount that it reaches beyond a characteristic speed",
    source: "A. Harnoy, B. Friedland, H. Rachoor, Wear 172 (1994) 155–165: the rising branch of a lubricated contact",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "strengthening_torque",
            unit: "mNm",
            symbol: "F",
            description: "friction far beyond the characteristic speed above the Coulomb friction",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "strengthening_speed",
            unit: "rad/s",
            symbol: "v",
            description: "speed over which it is reached",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::Friction(|values, motion, direction| direction.sign() * values[0] * risen(values, motion)),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1],
        fill: |effect, motion, row| {
            row[0] = motion.velocity_sign() * risen(effect.values(), motion);
        },
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[0],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 1,
            // Far above the motion's speeds it is viscous friction, far below it Coulomb friction.
            range: |scene| Some((0.02 * scene.median_speed_rad_s, scene.highest_speed_rad_s)),
            starts: |_| 8,
            logarithmic: true,
            is_coulomb_at_least: true,
            ..Search::PLAIN
        }],
        ..Hypothesis::PLAIN
    }),
};

fn risen(values: &[f64], motion: &Motion) -> f64 {
    -(-motion.velocity_rad_s.abs() / values[1]).exp_m1()
}
