//! A rig behind a shared library.

use hal::RigFile;
use hal::plugin::{PluginRig, TEMPLATE};

use super::{Rig, RigKind, refuse_simulated};
use crate::plan::PlanError;
use crate::request::RunRequest;

pub(super) static KIND: RigKind = RigKind {
    name: "plugin",
    description: "a shared library with the C interface of haptic_rig.h",
    template: TEMPLATE,
    make,
    scan: None,
};

fn make(file: &RigFile, request: &RunRequest) -> Result<Rig, PlanError> {
    refuse_simulated(file, request)?;
    let apparatus = PluginRig::open(file, request.pace.rate_hz)?;
    Ok(Rig { apparatus: Box::new(apparatus), simulated_knob: None })
}
