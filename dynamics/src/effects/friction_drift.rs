//! Friction that changes with time.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, RangeEnd, Regressors, Role, Search};

/// `friction-drift`: all friction times 1 + d·exp(−t/T), as when grease warms.
pub static KIND: EffectKind = EffectKind {
    name: "friction-drift",
    description: "friction changes with the time since the start of the capture and settles",
    source: "first-order warming of a lubricant",
    role: Role::Friction,
    depends_on: &[Coordinate::Time],
    parameters: &[
        ParameterKind {
            name: "drift_excess",
            unit: "1",
            symbol: "d",
            description: "relative excess of friction at the start",
            minimum: Minimum::None,
        },
        ParameterKind {
            name: "drift_time",
            unit: "s",
            symbol: "T",
            description: "time constant of settling",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::FrictionFactor(|values, motion| values[0] * (-motion.time_s / values[1]).exp()),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1],
        fill: |effect, motion, row| row[0] = (-motion.time_s / effect.values()[1]).exp(),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 1,
            range: |scene| Some((0.05 * scene.duration_s, 5.0 * scene.duration_s)),
            starts: |_| 6,
            logarithmic: true,
            straight_end: Some(RangeEnd::Largest),
            ..Search::PLAIN
        }],
        ..Hypothesis::PLAIN
    }),
};
