//! The simulated rig.

use dynamics::knobs::Fixture;
use hal::RigFile;
use hal::simulated_rig::{RIG_FILE, RigParameters, SimulatedRig};

use super::hand::hand;
use super::{Rig, RigKind};
use crate::plan::{PlanError, mounted_knob};
use crate::request::{RunRequest, SimulatedRequest, default_knob};

pub(super) static KIND: RigKind =
    RigKind { name: "simulated", description: "the simulated rig with any knob", template: RIG_FILE, make, scan: None };

/// Seed of the noise where none is asked for.
const SEED: u64 = 1;

fn make(file: &RigFile, request: &RunRequest) -> Result<Rig, PlanError> {
    let own = [
        ("[channels]", file.channels.is_some()),
        ("[watchdog]", file.watchdog.is_some()),
        ("[calls]", file.calls.is_some()),
        ("device", file.device.is_some()),
    ];
    if let Some((key, _)) = own.into_iter().find(|(_, is_given)| *is_given) {
        return Err(file
            .error(format!("the {key} of the simulated rig is fixed; omit it, or change [settings]"))
            .into());
    }
    let parameters: RigParameters = file.settings()?;
    let SimulatedRequest { seed, motor_cogging, hand: asked } = &request.rig.simulated;
    let (knob, hand) = match (&request.rendering, asked) {
        // Whatever is rendered, nothing but a hand is on the gripper.
        (Some(_), Some(asked)) => (Fixture::None.model_on(file.axis)?, hand(asked, file.axis, request.amplitude)?),
        (Some(_), None) => (Fixture::None.model_on(file.axis)?, None),
        (None, _) => {
            (mounted_knob(request.knob.as_deref().unwrap_or(default_knob(file.axis)), file.axis, &file.name)?, None)
        }
    };
    let motor_cogging = if motor_cogging.is_empty() { parameters.motor_cogging.clone() } else { motor_cogging.clone() };
    let parameters = RigParameters { motor_cogging, ..parameters }.at_rate(request.pace.rate_hz);
    let apparatus = SimulatedRig::held(parameters, knob.clone(), hand, seed.unwrap_or(SEED))
        .map_err(|error| PlanError::Unmountable(error.to_string()))?;
    Ok(Rig { apparatus: Box::new(apparatus), simulated_knob: Some(knob) })
}
