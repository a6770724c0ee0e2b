//! A shaft that twists between sensor and knob.

use crate::{Coordinate, Coupling, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Role, Scene, Search};

/// `shaft-compliance`: the knob turns on a torsional spring and damper; see [`crate::Coupling`].
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
    ],
    part: Part::Coupling(|values| Coupling {
        half_gap_rad: 0.0,
        inner_share: 1.0,
        stiffness_mnm_rad: values[0],
        damping: values[1],
    }),
    steepest_mnm_rad: None,
    regressors: None,
    hypothesis: Some(Hypothesis {
        searched: &[
            Search {
                parameter: 0,
                // Of a higher resonance the band has the first rise only, which a resonance of the sensor makes as well.
                range: |scene| scene.resonant_stiffnesses(5.0, 2.5 * scene.band_hz),
                starts: |_| 24,
                logarithmic: true,
                ..Search::PLAIN
            },
            Search { parameter: 1, range: Scene::coupling_dampings, starts: |_| 1, logarithmic: true, ..Search::PLAIN },
        ],
        ..Hypothesis::PLAIN
    }),
};
