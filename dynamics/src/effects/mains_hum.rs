//! Mains hum on the torque sensor.

use std::f64::consts::TAU;

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Regressors, Role, Search};

/// `mains-hum`: the reading is the torque plus U·sin(2πft + υ), f near 50 or 60 Hz.
pub static KIND: EffectKind = EffectKind {
    name: "mains-hum",
    description: "a 50 or 60 Hz sinusoid on the torque sensor",
    source: "pick-up from the mains; frequencies of the European and American grids",
    role: Role::Other,
    depends_on: &[Coordinate::Time],
    parameters: &[
        ParameterKind {
            name: "hum_torque",
            unit: "mNm",
            symbol: "U",
            description: "amplitude of the reading",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "hum_frequency",
            unit: "Hz",
            symbol: "f",
            description: "frequency",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "hum_phase",
            unit: "rad",
            symbol: "υ",
            description: "phase at the start of the capture",
            minimum: Minimum::None,
        },
    ],
    part: Part::Reading(|values, motion| values[0] * (TAU * values[1] * motion.time_s + values[2]).sin()),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 2,
        searched: &[1],
        fill: |effect, motion, row| (row[0], row[1]) = (TAU * effect.values()[1] * motion.time_s).sin_cos(),
        values: |coefficients, values| {
            values[0] = coefficients[0].hypot(coefficients[1]);
            values[2] = coefficients[1].atan2(coefficients[0]);
        },
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 1,
            // A strong line shows beyond the band's edge too.
            range: |scene| {
                let highest_hz = (1.2 * scene.band_hz).min(61.0);
                (highest_hz > 51.0).then_some((49.0, highest_hz))
            },
            starts: |scene| Search::starts_over(12.0 * scene.duration_s),
            ..Search::PLAIN
        }],
        per_capture: true,
        ..Hypothesis::PLAIN
    }),
};
