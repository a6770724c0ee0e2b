//! What is on a bus, and a rig file to begin with.

use std::fmt::Write as _;

use ethercrab::error::Error;

use super::bring_up::{BringUpError, Reference, find, mapped, open, wait};
use super::drive::{PROFILE, object};
use super::entries::Entry;
use super::{TEMPLATE, interface};
use crate::Scanned;

/// Whether a target is a network interface that can carry EtherCAT.
#[must_use]
pub fn knows(target: &str) -> bool {
    interface::is_ethernet(target)
}

/// A device that was found.
struct Found {
    name: String,
    vendor: u32,
    product: u32,
    alias: u16,
    is_drive: bool,
    has_clock: bool,
    outputs: Vec<Entry>,
    inputs: Vec<Entry>,
}

/// Lists the devices on an interface with what they exchange; they are taken to PRE-OP, where nothing moves.
///
/// # Errors
/// [`BringUpError`], also where nothing answers.
pub fn scan(interface: &str, stop: &dyn Fn() -> bool) -> Result<Scanned, BringUpError> {
    let (mut wire, main_device) = open(interface, 0)?;
    let found = wait(&mut wire, interface, stop, async {
        let group = find(&main_device, interface).await?;
        let mut found = Vec::new();
        for device in group.iter(&main_device) {
            found.push(look(&device).await.map_err(|reason| BringUpError::Bus {
                doing: format!("reading what '{}' exchanges", device.name()),
                reason,
            })?);
        }
        Ok(found)
    })?;
    let lines = found.iter().enumerate().flat_map(|(position, device)| device.lines(position)).collect();
    Ok(Scanned { lines, rig_file: rig_file(interface, &found) })
}

async fn look(reference: &Reference<'_>) -> Result<Found, Error> {
    let identity = reference.identity();
    let outputs = mapped(reference, 0x1c12).await?;
    let inputs = mapped(reference, 0x1c13).await?;
    let kind = reference.sdo_read::<u32>(object::DEVICE_TYPE.index, 0).await;
    Ok(Found {
        name: reference.name().to_owned(),
        vendor: identity.vendor_id,
        product: identity.product_id,
        alias: reference.alias_address(),
        is_drive: kind.is_ok_and(|kind| kind & 0xffff == PROFILE),
        has_clock: reference.dc_support().any(),
        outputs,
        inputs,
    })
}

fn list(entries: &[Entry]) -> String {
    entries.iter().map(|entry| format!("\"{entry}\"")).collect::<Vec<_>>().join(", ")
}

impl Found {
    fn lines(&self, position: usize) -> Vec<String> {
        let Self { name, vendor, product, alias, is_drive, has_clock, outputs, inputs } = self;
        let drive = if *is_drive { ", a CiA 402 drive" } else { "" };
        let clock = if *has_clock { ", with a distributed clock" } else { "" };
        let mut lines =
            vec![format!("{position}  {name}: vendor {vendor:#x}, product {product:#x}, alias {alias}{drive}{clock}")];
        let entries = [("takes", outputs), ("gives", inputs)];
        lines.extend(entries.into_iter().filter(|(_, entries)| !entries.is_empty()).map(|(what, entries)| {
            format!("   {what} {}", entries.iter().map(Entry::to_string).collect::<Vec<_>>().join(" "))
        }));
        lines
    }

    /// The keys by which a rig file finds it.
    fn keys(&self, position: usize) -> String {
        format!("position = {position}\nvendor = {:#x}\nproduct = {:#x}\n", self.vendor, self.product)
    }
}

/// The template with the devices that were found; `None` where none of them is a drive.
fn rig_file(interface: &str, found: &[Found]) -> Option<String> {
    let (at, drive) = found.iter().enumerate().find(|(_, device)| device.is_drive)?;
    let mut devices = format!("[settings.drive]              # {}\n{}", drive.name, drive.keys(at));
    let _ = writeln!(devices, "outputs = [\"0x6040:00/16\", \"0x6071:00/16\", \"0x6060:00/8\"]");
    let _ = writeln!(
        devices,
        "inputs = [\"0x6041:00/16\", \"0x6064:00/32\", \"0x6077:00/16\", \"0x603f:00/16\", \"0x6061:00/8\"]"
    );
    let _ = writeln!(
        devices,
        "# as found: outputs = [{}]\n# as found: inputs = [{}]",
        list(&drive.outputs),
        list(&drive.inputs)
    );
    for (position, device) in
        found.iter().enumerate().filter(|(_, device)| !device.is_drive && !device.inputs.is_empty())
    {
        let _ = write!(
            devices,
            "\n[settings.terminals.terminal{position}]  # {}\n{}# gives {}\n",
            device.name,
            device.keys(position),
            list(&device.inputs)
        );
    }
    let start = TEMPLATE.find("[settings.drive]")?;
    let end = TEMPLATE.find("# quantity = ")?;
    let text = format!("{}{devices}\n{}", &TEMPLATE[..start], &TEMPLATE[end..]);
    Some(text.replace("interface = \"enp3s0\"", &format!("interface = \"{interface}\"")))
}
