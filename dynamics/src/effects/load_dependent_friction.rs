//! Friction that grows with the load.

use crate::{Coordinate, EffectKind, Hypothesis, Minimum, ParameterKind, Part, Role};

/// `load-dependent-friction`: friction is larger by μ·|load|, the load being the torque of inertia, detents and springs.
///
/// Where the acceleration is not known beforehand, on a rig that simulates or renders the knob, the load is that of
/// detents and springs.
pub static KIND: EffectKind = EffectKind {
    name: "load-dependent-friction",
    description: "friction grows with the torque that the mechanism carries",
    source: "Coulomb friction of a loaded gear, screw or detent spring: P. Hamon, M. Gautier, P. Garrec, IROS 2010, 6187",
    role: Role::Friction,
    depends_on: &[Coordinate::Load],
    parameters: &[ParameterKind {
        name: "load_friction_coefficient",
        unit: "1",
        symbol: "μ",
        description: "friction over the load",
        minimum: Minimum::ShareOfOne,
    }],
    part: Part::LoadFriction(|values| values[0]),
    steepest_mnm_rad: None,
    // Its column depends on the other effects' values.
    regressors: None,
    hypothesis: Some(Hypothesis::PLAIN),
};
