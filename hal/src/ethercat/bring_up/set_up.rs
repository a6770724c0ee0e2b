//! What is written to a device before it exchanges process data, and read from it.

use ethercrab::error::Error;
use ethercrab::{SubDevice, SubDeviceRef};

use super::Asked;
use super::error::{BringUpError, failed, unsuitable};
use super::find::Named;
use crate::ethercat::drive::{CYCLIC_SYNCHRONOUS_TORQUE, PROFILE, interpolation_period, object};
use crate::ethercat::entries::{DRIVE, Entry, Object};
use crate::ethercat::settings::Startup;

/// A device as it can be talked to before it has process data.
pub(in crate::ethercat) type Reference<'a> = SubDeviceRef<'a, &'a SubDevice>;

/// Writes what the file has for a device, and reads which entries it then exchanges.
pub(super) async fn set_up(reference: &Reference<'_>, device: &mut Named<'_>) -> Result<(), BringUpError> {
    let Named { name, asked, .. } = *device;
    for startup in &asked.startup {
        write(reference, name, startup).await?;
    }
    for (assignment, mapping, entries) in [(0x1c12, 0x1600, &asked.outputs), (0x1c13, 0x1a00, &asked.inputs)] {
        let Some(entries) = entries else { continue };
        let mut writes = vec![startup(assignment, 0, 8, 0), startup(mapping, 0, 8, 0)];
        for (place, entry) in entries.iter().enumerate() {
            writes.push(startup(mapping, place as u8 + 1, 32, i64::from(entry.word())));
        }
        writes.push(startup(mapping, 0, 8, entries.len() as i64));
        writes.push(startup(assignment, 1, 16, i64::from(mapping)));
        writes.push(startup(assignment, 0, 8, 1));
        for one in writes {
            write(reference, name, &one).await?;
        }
    }
    device.outputs = mapped(reference, 0x1c12).await.map_err(failed(format!("reading what '{name}' takes")))?;
    device.inputs = mapped(reference, 0x1c13).await.map_err(failed(format!("reading what '{name}' gives")))?;
    Ok(())
}

fn startup(index: u16, subindex: u8, bits: u8, value: i64) -> Startup {
    Startup { index, subindex, bits, value }
}

/// Writes a value to an object.
async fn write(reference: &Reference<'_>, name: &str, startup: &Startup) -> Result<(), BringUpError> {
    let Startup { index, subindex, bits, value } = *startup;
    let written = match bits {
        8 => reference.sdo_write(index, subindex, value as u8).await,
        16 => reference.sdo_write(index, subindex, value as u16).await,
        32 => reference.sdo_write(index, subindex, value as u32).await,
        _ => return Err(unsuitable(name, format!("cannot be written {bits} bits at once; give 8, 16 or 32"))),
    };
    written.map_err(|error| {
        let object = Object::new(index, subindex);
        unsuitable(name, format!("does not take {value:#x} ({bits} bits) for its object {object}: {error}"))
    })
}

/// The entries that a device exchanges, by its own objects (ETG.1000.6, 5.6.7.4); none where it has no such objects.
pub(in crate::ethercat) async fn mapped(reference: &Reference<'_>, assignment: u16) -> Result<Vec<Entry>, Error> {
    let count = match reference.sdo_read::<u8>(assignment, 0).await {
        Ok(count) => count,
        Err(Error::Mailbox(_)) => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut entries = Vec::new();
    for at in 1..=count {
        let mapping = reference.sdo_read::<u16>(assignment, at).await?;
        for entry in 1..=reference.sdo_read::<u8>(mapping, 0).await? {
            entries.push(Entry::of_word(reference.sdo_read::<u32>(mapping, entry).await?));
        }
    }
    Ok(entries)
}

/// An object of 32 bits, where the device has it.
async fn read(reference: &Reference<'_>, object: Object) -> Option<u32> {
    reference.sdo_read::<u32>(object.index, object.subindex).await.ok()
}

/// Makes sure that the drive is one, sets its mode and period, and reads its scales: rated torque, mNm, and counts per turn.
pub(super) async fn set_up_drive(
    reference: &Reference<'_>,
    asked: &Asked<'_>,
) -> Result<(f64, Option<f64>), BringUpError> {
    let settings = asked.settings;
    if let Some(kind) = read(reference, object::DEVICE_TYPE).await
        && kind & 0xffff != PROFILE
    {
        return Err(unsuitable(
            DRIVE,
            format!("is no CiA 402 drive: its device type is {kind:#010x}; choose another one"),
        ));
    }
    if let Some(modes) = read(reference, object::SUPPORTED_MODES).await
        && modes >> (CYCLIC_SYNCHRONOUS_TORQUE - 1) & 1 == 0
    {
        return Err(unsuitable(
            DRIVE,
            "offers no cyclic synchronous torque (bit 9 of 0x6502), by which it would be driven",
        ));
    }
    let mode = startup(object::MODE.index, 0, 8, i64::from(CYCLIC_SYNCHRONOUS_TORQUE));
    write(reference, DRIVE, &mode).await?;
    if let Some((units, exponent)) = interpolation_period(asked.rate_hz) {
        // Drives that have a fixed period do not have the object.
        let (time, power) = (object::INTERPOLATION_TIME, object::INTERPOLATION_EXPONENT);
        let _ = reference.sdo_write(time.index, time.subindex, units).await;
        let _ = reference.sdo_write(power.index, power.subindex, exponent).await;
    }
    let rated_torque_mnm = match settings.rated_torque_mnm {
        Some(rated_torque_mnm) => rated_torque_mnm,
        None => read(reference, object::RATED_TORQUE).await.map(f64::from).filter(|rated| *rated > 0.0).ok_or_else(
            || unsuitable(DRIVE, "does not tell its rated torque (0x6076); write rated_torque_mnm under [settings]"),
        )?,
    };
    let of_drive =
        match (read(reference, object::ENCODER_INCREMENTS).await, read(reference, object::ENCODER_TURNS).await) {
            (Some(counts), Some(turns)) if counts > 0 && turns > 0 => Some(f64::from(counts) / f64::from(turns)),
            _ => None,
        };
    Ok((rated_torque_mnm, settings.counts_per_turn.or(of_drive)))
}
