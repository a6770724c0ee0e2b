//! Stick: a knob at rest bears more torque than it needs to keep sliding.

use crate::{Coordinate, EffectKind, Minimum, ParameterKind, Part, Role, StickLimits};

/// `karnopp-stick`: below the speed Δv the knob comes to rest and then holds up to D₋ or D₊.
pub static KIND: EffectKind = EffectKind {
    name: "karnopp-stick",
    description: "at rest the knob holds until a threshold torque is passed",
    source: "D. Karnopp, Computer simulation of stick-slip friction in mechanical dynamic systems, \
             ASME J. Dyn. Syst. Meas. Control 107 (1985) 100–103",
    role: Role::Friction,
    depends_on: &[Coordinate::Velocity, Coordinate::Load],
    parameters: &[
        ParameterKind {
            name: "static_negative",
            unit: "mNm",
            symbol: "D₋",
            description: "torque that a knob at rest bears in the negative direction, a magnitude",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "static_positive",
            unit: "mNm",
            symbol: "D₊",
            description: "torque that a knob at rest bears in the positive direction",
            minimum: Minimum::Zero,
        },
        ParameterKind {
            name: "stick_velocity",
            unit: "rad/s",
            symbol: "Δv",
            description: "speed below which the knob comes to rest",
            minimum: Minimum::Zero,
        },
    ],
    part: Part::Stick(|values| StickLimits {
        negative_mnm: values[0],
        positive_mnm: values[1],
        velocity_rad_s: values[2],
    }),
    steepest_mnm_rad: None,
    // A resting knob's torque is whatever holds it: no function of the motion, so nothing to regress on.
    regressors: None,
    hypothesis: None,
};
