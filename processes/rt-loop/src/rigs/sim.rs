//! The simulated rig.

use dynamics::knobs::Fixture;
use hal::simulated::{RigParameters, SimulatedRig};

use super::hand::hand;
use super::{Rig, RigKind};
use crate::plan::{PlanError, mounted_knob};
use crate::request::{RunRequest, SimulatedRequest};

pub(super) static KIND: RigKind = RigKind { name: "sim", description: "the simulated rig", make };

fn make(request: &RunRequest) -> Result<Rig, PlanError> {
    let SimulatedRequest { seed, motor_cogging, hand: asked } = &request.rig.simulated;
    let (knob, hand) = match (&request.rendering, asked) {
        // Whatever is rendered, nothing but a hand is on the gripper.
        (Some(_), Some(asked)) => (Fixture::None.model()?, hand(asked, request.amplitude)?),
        (Some(_), None) => (Fixture::None.model()?, None),
        (None, _) => (mounted_knob(&request.knob)?, None),
    };
    let parameters = RigParameters { motor_cogging: motor_cogging.clone(), ..RigParameters::default() };
    let apparatus = SimulatedRig::held(parameters, knob.clone(), hand, *seed)
        .map_err(|error| PlanError::Unmountable(error.to_string()))?;
    Ok(Rig { apparatus: Box::new(apparatus), simulated_knob: Some(knob) })
}
