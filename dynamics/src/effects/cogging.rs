//! A second sinusoid of the angle, such as a motor's poles make.

use std::f64::consts::TAU;

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role, Scene, Search};

/// `cogging`: τ = H·sin(n·θ + η), its period unrelated to the detents'.
pub static KIND: EffectKind = EffectKind {
    name: "cogging",
    description: "a sinusoid of the angle whose period has nothing to do with the detents",
    source: "poles and slots of a motor, or a second wheel",
    role: Role::Detents,
    depends_on: &[Coordinate::Angle],
    parameters: &[
        ParameterKind {
            name: "cogging_torque",
            unit: "mNm",
            symbol: "H",
            description: "largest torque",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "cogging_per_turn",
            unit: "1",
            symbol: "n",
            description: "periods per turn",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "cogging_phase",
            unit: "rad",
            symbol: "η",
            description: "phase at angle zero",
            minimum: Minimum::None,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * (values[1] * motion.angle_rad + values[2]).sin()),
    steepest_mnm_rad: Some(|effect| (effect.values()[0] * effect.values()[1]).abs()),
    regressors: Some(Regressors {
        columns: 2,
        searched: &[1],
        fill: |effect, motion, row| (row[0], row[1]) = (effect.values()[1] * motion.angle_rad).sin_cos(),
        values: |coefficients, values| {
            values[0] = coefficients[0].hypot(coefficients[1]);
            values[2] = coefficients[1].atan2(coefficients[0]);
        },
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 1,
            range: |scene| {
                // Fewer than two periods over the travel are a bend.
                let fewest = (2.0 * TAU / scene.travel_rad()).max(1.5);
                let most = finest_per_turn(scene);
                (most > fewest).then_some((fewest, most))
            },
            starts: |scene| Search::starts_over(finest_per_turn(scene) * scene.travel_rad() / TAU),
            logarithmic: false,
            same_as: None,
        }],
        nested: &[],
        least_travel_rad: 0.0,
        per_capture: false,
    }),
};

/// Most periods per turn that pass slowly enough for the band.
fn finest_per_turn(scene: &Scene) -> f64 {
    TAU * scene.band_hz / (0.5 * scene.median_speed_rad_s).max(f64::MIN_POSITIVE)
}
