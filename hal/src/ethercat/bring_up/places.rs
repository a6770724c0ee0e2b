//! Where values lie in the process data.

use super::error::{BringUpError, unsuitable};
use super::find::Named;
use crate::ethercat::bus::{ChannelPlace, DrivePlaces};
use crate::ethercat::drive::object;
use crate::ethercat::entries::{Coding, DRIVE, Entry, Object, Place, Source, What};

/// Where the drive's words lie.
pub(super) fn drive_places(drive: &Named<'_>) -> Result<DrivePlaces, BringUpError> {
    let must = |object: Object, entries: &[Entry], key: &str, bits: u8| {
        Place::of(object, entries).ok_or_else(|| {
            let there: Vec<String> = entries.iter().map(Entry::to_string).collect();
            let what = format!(
                "has no {object} among its {key}: {}; write `{key}` with \"{object}/{bits}\" under [settings.drive]",
                there.join(", ")
            );
            unsuitable(DRIVE, what)
        })
    };
    Ok(DrivePlaces {
        device: drive.index,
        controlword: must(object::CONTROLWORD, &drive.outputs, "outputs", 16)?,
        target_torque: must(object::TARGET_TORQUE, &drive.outputs, "outputs", 16)?,
        mode: Place::of(object::MODE, &drive.outputs),
        statusword: must(object::STATUSWORD, &drive.inputs, "inputs", 16)?,
        mode_display: Place::of(object::MODE_DISPLAY, &drive.inputs),
        error_code: Place::of(object::ERROR_CODE, &drive.inputs),
    })
}

/// What the drive's numbers stand for.
#[derive(Clone, Copy)]
pub(super) struct Scales {
    pub(super) rated_torque_mnm: f64,
    pub(super) counts_per_turn: Option<f64>,
}

/// Where a channel's value lies.
pub(super) fn channel_place(
    source: &Source,
    named: &[Named<'_>],
    scales: Scales,
) -> Result<ChannelPlace, BringUpError> {
    let missing = |device: &str, there: String| BringUpError::NoInput {
        source_name: source.to_string(),
        device: device.to_owned(),
        there,
    };
    let device = named.iter().find(|device| device.name == source.device).ok_or_else(|| {
        missing(
            &source.device,
            format!("[settings] names {}", named.iter().map(|device| device.name).collect::<Vec<_>>().join(", ")),
        )
    })?;
    let rad_per_count = || {
        scales.counts_per_turn.map(|counts| std::f64::consts::TAU / counts).ok_or_else(|| {
            unsuitable(DRIVE, "does not tell its encoder's counts (0x608f); write counts_per_turn under [settings]")
        })
    };
    let (object, coding, factor) = match source.what {
        What::Position => (object::POSITION, Coding::Signed, rad_per_count()?),
        What::Velocity => (object::VELOCITY, Coding::Signed, rad_per_count()?),
        What::Torque => (object::TORQUE, Coding::Signed, scales.rated_torque_mnm / 1e3),
        What::Raw(object, coding) => (object, coding, 1.0),
    };
    let place = Place::of(object, &device.inputs).ok_or_else(|| {
        missing(device.name, device.inputs.iter().map(Entry::to_string).collect::<Vec<_>>().join(", "))
    })?;
    Ok(ChannelPlace { device: device.index, place, coding, factor })
}
