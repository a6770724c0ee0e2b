//! A shaft that twists between the sensor and the body on which friction and detents act.

use crate::{Coordinate, Coupling, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Role, Scene, Search};

/// Index of the share of inertia in front of the shaft among the parameters.
pub const OUTER_SHARE: usize = 2;
/// Largest share of the inertia that is looked for on either side.
pub const LARGEST_SHARE: f64 = 0.98;

/// `shaft-compliance`: the knob, apart from the outer share of its inertia, turns on a torsional spring and damper; see [`crate::Coupling`].
pub static KIND: EffectKind = EffectKind {
    name: "shaft-compliance",
    description: "a torsional spring between the sensor and the knob, which therefore resonates",
    source: "two inertias on a shaft",
    role: Role::Other,
    depends_on: &[Coordinate::Load],
    parameters: &[
        ParameterKind {
            name: "shaft_stiffness",
            unit: "mNm/rad",
            symbol: "K",
            description: "torque per twist",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "shaft_damping",
            unit: "mNm s/rad",
            symbol: "D",
            description: "torque per rate of twist",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "shaft_outer_share",
            unit: "1",
            symbol: "ν",
            description: "share of the inertia on the sensor's side of the shaft; zero if left out",
            minimum: Minimum::ZeroOrAbsent,
        },
    ],
    part: Part::Coupling(|values| Coupling {
        half_gap_rad: 0.0,
        inner_share: 1.0 - values[OUTER_SHARE],
        stiffness_mnm_rad: values[0],
        damping: values[1],
    }),
    steepest_mnm_rad: None,
    regressors: None,
    hypothesis: Some(Hypothesis {
        searched: &[
            Search {
                parameter: 0,
                // The band shows only the first rise of a higher resonance, and a resonance of the sensor causes such a rise too.
                range: |scene| scene.resonant_stiffnesses(5.0, 2.5 * scene.band_hz),
                starts: |_| 24,
                logarithmic: true,
                ..Search::PLAIN
            },
            Search { parameter: 1, range: Scene::coupling_dampings, starts: |_| 1, logarithmic: true, ..Search::PLAIN },
            Search {
                parameter: OUTER_SHARE,
                range: |_| Some((1.0 - LARGEST_SHARE, LARGEST_SHARE)),
                starts: |_| 3,
                ..Search::PLAIN
            },
        ],
        ..Hypothesis::PLAIN
    }),
};
