//! Lost motion between the cap and the inner body.

use crate::{Coordinate, Coupling, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Role, Scene, Search};

/// Index of the share of inertia behind the gap among the parameters.
pub const INNER_SHARE: usize = 1;
/// Index of the contact's damping among the parameters.
pub const DAMPING: usize = 3;

/// `backlash`: cap and inner body touch only where their angles differ by more than half a gap; see [`crate::Coupling`].
pub static KIND: EffectKind = EffectKind {
    name: "backlash",
    description: "lost motion between the sensor and the inner part that carries friction and detents",
    source: "contact of Kelvin and Voigt with a dead zone",
    role: Role::Other,
    depends_on: &[Coordinate::Load],
    parameters: &[
        ParameterKind {
            name: "backlash_half_gap",
            unit: "rad",
            symbol: "g",
            description: "half of the lost motion",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "backlash_inner_share",
            unit: "1",
            symbol: "μ",
            description: "share of the inertia behind the gap",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "backlash_stiffness",
            unit: "mNm/rad",
            symbol: "K",
            description: "stiffness of the contact",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "backlash_damping",
            unit: "mNm s/rad",
            symbol: "D",
            description: "damping of the contact",
            minimum: Minimum::Zero,
        },
    ],
    part: Part::Coupling(|values| Coupling {
        half_gap_rad: values[0],
        inner_share: values[INNER_SHARE],
        stiffness_mnm_rad: values[2],
        damping: values[DAMPING],
    }),
    steepest_mnm_rad: None,
    regressors: None,
    hypothesis: Some(Hypothesis {
        searched: &[
            Search {
                parameter: 0,
                range: |scene| Some((scene.angle_step_rad.max(3e-6 * scene.travel_rad()), 0.1 * scene.travel_rad())),
                starts: |_| 10,
                logarithmic: true,
                ..Search::PLAIN
            },
            Search {
                parameter: INNER_SHARE,
                range: |_| Some((0.02, 0.98)),
                starts: |scene| if scene.is_faint { 5 } else { 2 },
                ..Search::PLAIN
            },
            Search {
                parameter: 2,
                // A resonance between the lowest that shows and the highest that the samples resolve.
                range: |scene| scene.resonant_stiffnesses(20.0, 0.4 / scene.sample_s),
                starts: |_| 2,
                logarithmic: true,
                ..Search::PLAIN
            },
            Search {
                parameter: DAMPING,
                range: Scene::coupling_dampings,
                starts: |_| 1,
                logarithmic: true,
                ..Search::PLAIN
            },
        ],
        ..Hypothesis::PLAIN
    }),
};
