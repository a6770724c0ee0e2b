//! Captures from MCAP archives.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{BufReader, Read as _};
use std::path::Path;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use shared_types::wire::CDR_LITTLE_ENDIAN_HEADER;
use shared_types::{LoopState, ModelChange, RunDescription};

use crate::capture::Capture;
use crate::channels::Schemas;
use crate::description::{CAPTURE_METADATA, GAPS_METADATA, attachment};
use crate::error::{ArchiveError, with_causes};
use crate::parse::parse_record;
use crate::records::{MAX_RECORD_BYTES, attachment_body_length, may_unpack_to};
use crate::schema::{FieldLayout, Layout};
use crate::sequence::{Gap, SequenceLedger};

/// Bytes read from the file at a time.
const READ_BYTES: usize = 1 << 20;

/// Reads an archive that must be whole; every checksum is compared.
pub(crate) fn load(path: &Path) -> Result<Capture, ArchiveError> {
    let mut content = Content::new(path);
    read_records(path, |opcode, body| content.record(opcode, body))?;
    content.into_capture()
}

/// Hands over every record of an archive that must be whole, those in chunks too, up to the end of the messages; what
/// follows only repeats. Every checksum is compared.
pub(crate) fn read_records(
    path: &Path,
    mut take: impl FnMut(u8, &[u8]) -> Result<(), ArchiveError>,
) -> Result<(), ArchiveError> {
    let file = foreign_files::open(path).map_err(|error| ArchiveError::file(path, error))?;
    let length = file.metadata().map_err(|error| ArchiveError::file(path, error))?.len();
    let mut file = BufReader::with_capacity(READ_BYTES, file);
    let mut unpacked = 0;
    let mut reader = LinearReader::new_with_options(
        LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(MAX_RECORD_BYTES),
    );
    let mut past_the_messages = false;
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| broken(path, &error))? {
            LinearReadEvent::ReadRequest(need) => {
                // A length that the file only claims makes no room in memory.
                let read = file
                    .read(reader.insert(need.clamp(1, READ_BYTES)))
                    .map_err(|error| ArchiveError::file(path, error))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, opcode } => {
                unpacked += data.len() as u64;
                if unpacked > may_unpack_to(length) {
                    let reason = format!("its {length} bytes unpack to more than a recording's would");
                    return Err(ArchiveError::Damaged { path: path.to_owned(), reason });
                }
                past_the_messages |= opcode == op::DATA_END;
                if !past_the_messages {
                    if opcode == op::ATTACHMENT && attachment_body_length(data) != Some(data.len() as u64) {
                        let reason = "an attachment's lengths do not fit its record".to_owned();
                        return Err(ArchiveError::Damaged { path: path.to_owned(), reason });
                    }
                    take(opcode, data)?;
                }
            }
        }
    }
    Ok(())
}

fn broken(path: &Path, error: &McapError) -> ArchiveError {
    match error {
        McapError::UnexpectedEof => ArchiveError::Truncated { path: path.to_owned() },
        other => ArchiveError::Damaged { path: path.to_owned(), reason: with_causes(other) },
    }
}

/// What was read so far.
struct Content<'a> {
    path: &'a Path,
    schemas: Schemas,
    /// Where the fields of a sample lie, by channel.
    samples: HashMap<u16, SampleFields>,
    /// Channels of rendered models.
    model_channels: HashSet<u16>,
    models: Vec<ModelChange>,
    rows: Rows,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    attachments: BTreeMap<String, Vec<u8>>,
}

impl<'a> Content<'a> {
    fn new(path: &'a Path) -> Self {
        Self {
            path,
            schemas: Schemas::default(),
            samples: HashMap::new(),
            model_channels: HashSet::new(),
            models: Vec::new(),
            rows: Rows::default(),
            metadata: BTreeMap::new(),
            attachments: BTreeMap::new(),
        }
    }

    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<(), ArchiveError> {
        match parse_record(opcode, body).map_err(|error| broken(self.path, &error))? {
            Record::Schema { header, data } => self.schemas.learn(header, &data),
            Record::Channel(channel) => self.channel(channel)?,
            Record::Message { header, data } => {
                if let Some(fields) = self.samples.get(&header.channel_id) {
                    let Some(()) = self.rows.push(fields, &data) else {
                        return Err(self.damaged("a sample is shorter than its schema says, or not little-endian CDR"));
                    };
                } else if self.model_channels.contains(&header.channel_id) {
                    let body = data.strip_prefix(&CDR_LITTLE_ENDIAN_HEADER);
                    let Some(change) = body.and_then(ModelChange::from_cdr_body) else {
                        return Err(self.damaged("a rendered model is not as its schema says"));
                    };
                    self.models.push(change);
                }
            }
            Record::Attachment { header, data, .. } => {
                self.attachments.insert(header.name, data.into_owned());
            }
            Record::Metadata(metadata) => {
                self.metadata.insert(metadata.name, metadata.metadata);
            }
            _ => {}
        }
        Ok(())
    }

    fn damaged(&self, reason: &str) -> ArchiveError {
        ArchiveError::Damaged { path: self.path.to_owned(), reason: reason.to_owned() }
    }

    fn channel(&mut self, channel: mcap::records::Channel) -> Result<(), ArchiveError> {
        let channel_id = channel.id;
        let Some(definition) = self.schemas.define(channel) else { return Ok(()) };
        if definition.holds_samples() {
            let layout = Layout::parse(&definition.schema_text)
                .map_err(|error| ArchiveError::Schema { path: self.path.to_owned(), error })?;
            self.samples.insert(channel_id, SampleFields::find(self.path, &layout)?);
        } else if definition.holds_models() {
            self.model_channels.insert(channel_id);
        }
        Ok(())
    }

    fn into_capture(self) -> Result<Capture, ArchiveError> {
        let Self { path, schemas: _, samples, model_channels: _, models, rows, metadata, attachments } = self;
        if samples.is_empty() {
            return Err(ArchiveError::NoSamples { path: path.to_owned() });
        }
        let description: Option<RunDescription> =
            attachments.get(attachment::RUN).and_then(|json| serde_json::from_slice(json).ok());
        let rate_hz = description
            .as_ref()
            .map(|run| run.rate_hz)
            .or_else(|| metadata.get(CAPTURE_METADATA)?.get("rate_hz")?.parse().ok())
            .filter(|rate: &f64| rate.is_finite() && *rate > 0.0)
            .ok_or_else(|| ArchiveError::NoRate { path: path.to_owned() })?;
        let gaps = recorded_gaps(&metadata).unwrap_or_else(|| rows.gaps());
        let rows = rows.without_unmeasured_fault();
        let Rows {
            seq,
            tick,
            state,
            missed_ticks,
            flags,
            angle_rad,
            velocity,
            acceleration,
            torque_mnm,
            commanded_angle,
            commanded_torque,
        } = rows;
        #[allow(clippy::cast_precision_loss, reason = "ticks stay far below 2^53")]
        let t_s = tick.iter().map(|&tick| tick as f64 / rate_hz).collect();
        let [state, missed_ticks, flags] =
            [state, missed_ticks, flags].map(|column| (!column.is_empty()).then_some(column));
        Ok(Capture {
            source: path.to_owned(),
            rate_hz,
            seq,
            tick,
            state,
            missed_ticks,
            flags,
            t_s,
            angle_rad,
            velocity_rad_s: present(velocity),
            acceleration_rad_s2: present(acceleration),
            torque_mnm,
            commanded_angle_rad: present(commanded_angle),
            commanded_torque_mnm: present(commanded_torque),
            gaps,
            models,
            description,
            metadata,
            attachments,
        })
    }
}

/// The gaps that the writer noted; it also knew what is missing at the end.
pub(crate) fn recorded_gaps(metadata: &BTreeMap<String, BTreeMap<String, String>>) -> Option<Vec<Gap>> {
    serde_json::from_str(metadata.get(GAPS_METADATA)?.get("gaps")?).ok()
}

/// A column that is NaN throughout was never measured.
fn present(column: Vec<f64>) -> Option<Vec<f64>> {
    column.iter().any(|value| !value.is_nan()).then_some(column)
}

/// Where a sample's fields lie.
struct SampleFields {
    seq: FieldLayout,
    tick: FieldLayout,
    angle_rad: FieldLayout,
    torque_mnm: FieldLayout,
    velocity_rad_s: Option<FieldLayout>,
    acceleration_rad_s2: Option<FieldLayout>,
    commanded_angle_rad: Option<FieldLayout>,
    commanded_torque_mnm: Option<FieldLayout>,
    state: Option<FieldLayout>,
    missed_ticks: Option<FieldLayout>,
    flags: Option<FieldLayout>,
}

impl SampleFields {
    fn find(path: &Path, layout: &Layout) -> Result<Self, ArchiveError> {
        let required = |field: &'static str| {
            layout.field(field).cloned().ok_or_else(|| ArchiveError::MissingField {
                path: path.to_owned(),
                field,
                found: layout.field_names(),
            })
        };
        let optional = |field: &str| layout.field(field).cloned();
        Ok(Self {
            seq: required("seq")?,
            tick: required("tick")?,
            angle_rad: required("angle_rad")?,
            torque_mnm: required("torque_mnm")?,
            velocity_rad_s: optional("velocity_rad_s"),
            acceleration_rad_s2: optional("acceleration_rad_s2"),
            commanded_angle_rad: optional("commanded_angle_rad"),
            commanded_torque_mnm: optional("commanded_torque_mnm"),
            state: optional("state"),
            missed_ticks: optional("missed_ticks"),
            flags: optional("flags"),
        })
    }
}

/// The columns as they grow.
#[derive(Default)]
struct Rows {
    seq: Vec<u64>,
    tick: Vec<u64>,
    state: Vec<u32>,
    missed_ticks: Vec<u32>,
    flags: Vec<u32>,
    angle_rad: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
    torque_mnm: Vec<f64>,
    commanded_angle: Vec<f64>,
    commanded_torque: Vec<f64>,
}

impl Rows {
    /// Adds a sample; `None` when the message does not hold what its schema says.
    fn push(&mut self, fields: &SampleFields, message: &[u8]) -> Option<()> {
        let body = message.strip_prefix(&CDR_LITTLE_ENDIAN_HEADER)?;
        self.seq.push(fields.seq.as_u64(body)?);
        self.tick.push(fields.tick.as_u64(body)?);
        self.angle_rad.push(fields.angle_rad.as_f64(body)?);
        self.torque_mnm.push(fields.torque_mnm.as_f64(body)?);
        for (column, field) in [
            (&mut self.velocity, &fields.velocity_rad_s),
            (&mut self.acceleration, &fields.acceleration_rad_s2),
            (&mut self.commanded_angle, &fields.commanded_angle_rad),
            (&mut self.commanded_torque, &fields.commanded_torque_mnm),
        ] {
            if let Some(field) = field {
                column.push(field.as_f64(body)?);
            }
        }
        for (column, field) in [
            (&mut self.state, &fields.state),
            (&mut self.missed_ticks, &fields.missed_ticks),
            (&mut self.flags, &fields.flags),
        ] {
            if let Some(field) = field {
                column.push(u32::try_from(field.as_u64(body)?).ok()?);
            }
        }
        Some(())
    }

    /// Leaves out the last sample of a run that ended because a sensor or the apparatus failed: it
    /// shows the fault and has no measurement.
    fn without_unmeasured_fault(mut self) -> Self {
        let measured = |value: Option<&f64>| value.is_none_or(|value| value.is_finite());
        let at_fault = self.state.last() == Some(&LoopState::Fault.code());
        if at_fault && !(measured(self.angle_rad.last()) && measured(self.torque_mnm.last())) {
            let Self {
                seq,
                tick,
                state,
                missed_ticks,
                flags,
                angle_rad,
                velocity,
                acceleration,
                torque_mnm,
                commanded_angle,
                commanded_torque,
            } = &mut self;
            for column in [angle_rad, velocity, acceleration, torque_mnm, commanded_angle, commanded_torque] {
                column.pop();
            }
            seq.pop();
            tick.pop();
            for column in [state, missed_ticks, flags] {
                column.pop();
            }
        }
        self
    }

    fn gaps(&self) -> Vec<Gap> {
        let mut ledger = SequenceLedger::default();
        for &seq in &self.seq {
            // A repeated sample shows as time that does not rise.
            let _ = ledger.admit(seq);
        }
        ledger.gaps().to_vec()
    }
}
