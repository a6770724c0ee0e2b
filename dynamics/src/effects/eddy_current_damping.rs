//! Drag of eddy currents, as magnetic detents have it.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, Motion, ParameterKind, Part, Regressors, Role, Search};

/// `eddy-current-damping`: τ = b·θ̇/(1 + (θ̇/v)²), largest at the speed v.
pub static KIND: EffectKind = EffectKind {
    name: "eddy-current-damping",
    description: "drag in proportion to speed that falls again beyond a characteristic speed",
    source: "J. H. Wouterse, Critical torque and speed of eddy current brake, IEE Proc. B 138 (1991) 153–158",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity],
    parameters: &[
        ParameterKind {
            name: "eddy_damping",
            unit: "mNm s/rad",
            symbol: "b",
            description: "drag per speed at low speed",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "eddy_speed",
            unit: "rad/s",
            symbol: "v",
            description: "speed of the largest drag",
            minimum: Minimum::AboveZero,
        },
    ],
    part: Part::Torque(|values, motion| values[0] * drag_per_damping(values, motion)),
    steepest_mnm_rad: None,
    regressors: Some(Regressors {
        columns: 1,
        searched: &[1],
        fill: |effect, motion, row| row[0] = drag_per_damping(effect.values(), motion),
        values: |coefficients, values| values[0] = coefficients[0],
        nonnegative: &[0],
    }),
    hypothesis: Some(Hypothesis {
        searched: &[Search {
            parameter: 1,
            // Far above the motion's speeds it is viscous friction, far below it Coulomb friction.
            range: |scene| Some((0.05 * scene.median_speed_rad_s, scene.highest_speed_rad_s)),
            starts: |_| 8,
            logarithmic: true,
            ..Search::PLAIN
        }],
        ..Hypothesis::PLAIN
    }),
};

fn drag_per_damping(values: &[f64], motion: &Motion) -> f64 {
    let velocity = motion.velocity_rad_s;
    velocity / (1.0 + (velocity / values[1]).powi(2))
}
