//! Friction whose contacts bend before they slip.

use crate::{Bristles, Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Role, Search};

/// `presliding-hysteresis`: Coulomb friction builds up over an angle z₀ after every reversal; see [`crate::Bristles`].
pub static KIND: EffectKind = EffectKind {
    name: "presliding-hysteresis",
    description: "friction behaves like bristles that bend before they slip",
    source: "P. Dahl, A solid friction model, Aerospace Corp. TOR-158 (1968)",
    role: Role::Friction,
    depends_on: &[Coordinate::Angle, Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "bristle_deflection",
            unit: "rad",
            symbol: "z₀",
            description: "angle over which friction builds up",
            minimum: Minimum::AboveZero,
        },
        ParameterKind {
            name: "bristle_damping",
            unit: "mNm s/rad",
            symbol: "σ",
            description: "damping while the bristles bend",
            minimum: Minimum::None,
        },
    ],
    part: Part::Bristles(|values| Bristles { deflection_rad: values[0], damping: values[1] }),
    steepest_mnm_rad: None,
    regressors: None,
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 0,
            range: |scene| {
                Some(((3.0 * scene.angle_step_rad).max(1e-5 * scene.travel_rad()), 0.2 * scene.travel_rad()))
            },
            starts: |_| 14,
            logarithmic: true,
            ..Search::PLAIN
        }],
        ..Hypothesis::PLAIN
    }),
};
