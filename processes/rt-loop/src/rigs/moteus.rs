//! A motor behind a moteus controller.

use hal::RigFile;
use hal::moteus::{MoteusRig, TEMPLATE, is_port, scan};

use super::{Rig, RigKind, Scan, refuse_simulated};
use crate::plan::PlanError;
use crate::request::RunRequest;

pub(super) static KIND: RigKind = RigKind {
    name: "moteus",
    description: "a moteus controller over fdcanusb, UART or SocketCAN",
    template: TEMPLATE,
    make,
    scan: Some(Scan { target: "a tty or a CAN interface", knows: is_port, look: |port, stop| Ok(scan(port, stop)?) }),
};

fn make(file: &RigFile, request: &RunRequest) -> Result<Rig, PlanError> {
    refuse_simulated(file, request)?;
    let apparatus = MoteusRig::new(file, request.pace.rate_hz)?;
    Ok(Rig { apparatus: Box::new(apparatus), simulated_knob: None })
}
