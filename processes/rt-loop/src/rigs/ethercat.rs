//! CiA 402 drives on EtherCAT.

use hal::RigFile;
use hal::ethercat::{EthercatRig, TEMPLATE, knows, scan};

use super::{Rig, RigKind, Scan, refuse_simulated};
use crate::plan::PlanError;
use crate::request::RunRequest;

pub(super) static KIND: RigKind = RigKind {
    name: "ethercat",
    description: "a CiA 402 servo drive on EtherCAT, with optional terminals",
    template: TEMPLATE,
    make,
    scan: Some(Scan { target: "an Ethernet interface", knows, look: |interface, stop| Ok(scan(interface, stop)?) }),
};

fn make(file: &RigFile, request: &RunRequest) -> Result<Rig, PlanError> {
    refuse_simulated(file, request)?;
    let apparatus = EthercatRig::new(file, request.pace.rate_hz)?;
    Ok(Rig { apparatus: Box::new(apparatus), simulated_knob: None })
}
