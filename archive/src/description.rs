//! The run's description inside an archive: metadata for people, attachments with checksums.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Seek, Write};

use shared_types::wire::WireMessage;
use shared_types::{RunDescription, Sample};

use crate::channels::ChannelDefinition;
use crate::error::ArchiveError;
use crate::sequence::SequenceLedger;

/// Name of the metadata record that describes the run.
pub const CAPTURE_METADATA: &str = "capture";
/// Name of the metadata record that lists missing samples.
pub const GAPS_METADATA: &str = "gaps";
/// Name of the metadata record that a recovered file carries.
pub const RECOVERY_METADATA: &str = "recovery";

/// Names of the attachments.
pub mod attachment {
    /// The run's description as JSON.
    pub const RUN: &str = "run.json";
    /// What each channel holds, as JSON.
    pub const CHANNELS: &str = "channels.json";
    /// The model of the knob: simulated or fitted.
    pub const MODEL: &str = "model.toml";
    /// The rig's calibration.
    pub const CALIBRATION: &str = "calibration.toml";
    /// The excitation.
    pub const EXCITATION: &str = "excitation.toml";
}

/// A file inside the archive: name, media type, content.
type AttachedFile = (&'static str, &'static str, Vec<u8>);

/// The attachments that describe a run.
pub(crate) fn attachments(
    description: &RunDescription,
    channels: &BTreeMap<u16, ChannelDefinition>,
) -> Result<Vec<AttachedFile>, ArchiveError> {
    let json = |value: serde_json::Result<Vec<u8>>| value.map_err(|error| ArchiveError::write(&error));
    let mut all = vec![
        (attachment::RUN, "application/json", json(serde_json::to_vec_pretty(description))?),
        (attachment::CHANNELS, "application/json", json(serde_json::to_vec(channels))?),
        (attachment::EXCITATION, "application/toml", description.excitation_toml.clone().into_bytes()),
        (attachment::CALIBRATION, "application/toml", description.calibration_toml.clone().into_bytes()),
    ];
    // A capture of a rendering is to be compared with the model that was rendered.
    if let Some(model) = description.rendered_model_toml.as_ref().or(description.simulated_knob_toml.as_ref()) {
        all.push((attachment::MODEL, "application/toml", model.clone().into_bytes()));
    }
    Ok(all)
}

/// Writes one attachment, dated by the run's start.
pub(crate) fn attach<W: Write + Seek>(
    mcap: &mut mcap::Writer<W>,
    time_ns: u64,
    name: &str,
    media_type: &str,
    content: &[u8],
) -> mcap::McapResult<()> {
    mcap.attach(&mcap::Attachment {
        log_time: time_ns,
        create_time: time_ns,
        name: name.to_owned(),
        media_type: media_type.to_owned(),
        data: Cow::Borrowed(content),
    })
}

/// The sample rate that an archive gives, Hz: in the run's description, or where that is missing in its metadata.
pub(crate) fn described_rate_hz(
    run: Option<&RunDescription>,
    metadata: &BTreeMap<String, BTreeMap<String, String>>,
) -> Option<f64> {
    let in_metadata = || metadata.get(CAPTURE_METADATA)?.get("rate_hz")?.parse().ok();
    run.map(|run| run.rate_hz).or_else(in_metadata).filter(|rate_hz: &f64| rate_hz.is_finite() && *rate_hz > 0.0)
}

/// The metadata record `capture`.
pub(crate) fn capture_metadata(description: &RunDescription) -> mcap::records::Metadata {
    let RunDescription {
        run_id,
        software_version,
        apparatus,
        axis,
        contact: _,
        knob,
        rate_hz,
        planned_ticks,
        clock,
        realtime,
        torque_late_ticks: _,
        excitation_toml,
        calibration_toml: _,
        simulated_knob_toml: _,
        rendered_model_toml: _,
        control_toml: _,
        device_codes,
        notes,
    } = description;
    let mut metadata = BTreeMap::from([
        ("run_id".to_owned(), format!("{run_id:016x}")),
        ("software_version".to_owned(), software_version.clone()),
        ("apparatus".to_owned(), apparatus.clone()),
        ("knob".to_owned(), knob.clone()),
        ("excitation".to_owned(), excitation_toml.clone()),
        ("rate_hz".to_owned(), rate_hz.to_string()),
        ("planned_ticks".to_owned(), planned_ticks.to_string()),
        ("clock.monotonic_time_ns".to_owned(), clock.monotonic_time_ns.to_string()),
        ("clock.wall_clock_time_ns".to_owned(), clock.wall_clock_time_ns.to_string()),
        ("realtime".to_owned(), realtime_in_words(*realtime)),
    ]);
    for field in Sample::fields() {
        let name = axis.words(field.name);
        if let Some(unit) = unit_of(&name) {
            metadata.insert(format!("unit.{name}"), unit.to_owned());
        }
    }
    for (code, meaning) in device_codes {
        metadata.insert(format!("device_code.{code}"), meaning.clone());
    }
    for (name, text) in notes {
        let note = metadata.entry(format!("note.{name}"));
        note.and_modify(|known| *known += &format!("; {text}")).or_insert_with(|| text.clone());
    }
    mcap::records::Metadata { name: CAPTURE_METADATA.to_owned(), metadata }
}

/// The metadata record `gaps`; `None` when no sample is missing.
pub(crate) fn gaps_metadata(ledger: &SequenceLedger) -> Result<Option<mcap::records::Metadata>, ArchiveError> {
    if ledger.missing() == 0 {
        return Ok(None);
    }
    let gaps = serde_json::to_string(ledger.gaps()).map_err(|error| ArchiveError::write(&error))?;
    let metadata =
        BTreeMap::from([("missing_samples".to_owned(), ledger.missing().to_string()), ("gaps".to_owned(), gaps)]);
    Ok(Some(mcap::records::Metadata { name: GAPS_METADATA.to_owned(), metadata }))
}

/// The unit that a column's name carries; `None` for counts and codes.
#[must_use]
pub fn unit_of(column: &str) -> Option<&'static str> {
    // The longest ending comes first: `_rad_s2` also ends like a shorter one would.
    [
        ("_rad_s2", "rad/s^2"),
        ("_rad_s", "rad/s"),
        ("_rad", "rad"),
        ("_mnm", "mNm"),
        ("_mm_s2", "mm/s^2"),
        ("_mm_s", "mm/s"),
        ("_mm", "mm"),
        ("_n", "N"),
        ("_ns", "ns"),
        ("_s", "s"),
    ]
    .into_iter()
    .find_map(|(ending, unit)| column.ends_with(ending).then_some(unit))
}

fn realtime_in_words(bits: u32) -> String {
    use shared_types::realtime::{FIFO, LOCKED, PINNED};
    let granted: Vec<&str> = [(FIFO, "SCHED_FIFO"), (LOCKED, "memory locked"), (PINNED, "pinned")]
        .into_iter()
        .filter_map(|(bit, name)| (bits & bit != 0).then_some(name))
        .collect();
    if granted.is_empty() { "none".to_owned() } else { granted.join(", ") }
}
