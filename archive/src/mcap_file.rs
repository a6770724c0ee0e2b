//! Captures from MCAP archives.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{BufReader, Read as _};
use std::path::Path;

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use shared_types::wire::CDR_LITTLE_ENDIAN_HEADER;
use shared_types::{Axis, LoopState, ModelChange, RunDescription, Sample};

use crate::capture::Capture;
use crate::channels::Schemas;
use crate::columns::{self, Column, Values};
use crate::description::{GAPS_METADATA, attachment, described_rate_hz};
use crate::error::{ArchiveError, with_causes};
use crate::parse::parse_record;
use crate::records::{MAX_RECORD_BYTES, attachment_body_length, may_unpack_to};
use crate::rig_account::{Account, AccountFields};
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
                // The file may claim any length, so no more than `READ_BYTES` are allocated at a time.
                let read = file
                    .read(reader.insert(need.clamp(1, READ_BYTES)))
                    .map_err(|error| ArchiveError::file(path, error))?;
                reader.notify_read(read);
            }
            LinearReadEvent::Record { data, opcode } => {
                unpacked += data.len() as u64;
                if unpacked > may_unpack_to(length) {
                    let reason = format!("its {length} bytes unpack to more than those of a recording");
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
    samples: HashMap<u16, (SampleFields, AccountFields)>,
    /// Channels of rendered models.
    model_channels: HashSet<u16>,
    models: Vec<ModelChange>,
    axis: Axis,
    rows: Rows,
    account: Account,
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
            axis: Axis::default(),
            rows: Rows::new(),
            account: Account::default(),
            metadata: BTreeMap::new(),
            attachments: BTreeMap::new(),
        }
    }

    fn record(&mut self, opcode: u8, body: &[u8]) -> Result<(), ArchiveError> {
        match parse_record(opcode, body).map_err(|error| broken(self.path, &error))? {
            Record::Schema { header, data } => self.schemas.learn(header, &data),
            Record::Channel(channel) => self.channel(channel)?,
            Record::Message { header, data } => {
                if let Some((fields, account_fields)) = self.samples.get(&header.channel_id) {
                    let body = data.strip_prefix(&CDR_LITTLE_ENDIAN_HEADER);
                    let taken = body.and_then(|body| {
                        self.account.take(account_fields, body);
                        self.rows.push(fields, body)
                    });
                    let Some(()) = taken else {
                        return Err(self.damaged("a sample is shorter than its schema says, or not little-endian CDR"));
                    };
                } else if self.model_channels.contains(&header.channel_id) {
                    let body = data.strip_prefix(&CDR_LITTLE_ENDIAN_HEADER);
                    let Some(change) = body.and_then(ModelChange::from_cdr_body) else {
                        return Err(self.damaged("a rendered model does not match its schema"));
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
            let fields = (sample_fields(self.path, &layout)?, AccountFields::find(&layout));
            self.samples.insert(channel_id, fields);
            self.axis = axis_of(&layout);
        } else if definition.holds_models() {
            self.model_channels.insert(channel_id);
        }
        Ok(())
    }

    fn into_capture(self) -> Result<Capture, ArchiveError> {
        let Self { path, schemas: _, samples, model_channels: _, models, axis, rows, account, metadata, attachments } =
            self;
        if samples.is_empty() {
            return Err(ArchiveError::NoSamples { path: path.to_owned() });
        }
        let description: Option<RunDescription> =
            attachments.get(attachment::RUN).and_then(|json| serde_json::from_slice(json).ok());
        let rate_hz = described_rate_hz(description.as_ref(), &metadata)
            .ok_or_else(|| ArchiveError::NoRate { path: path.to_owned() })?;
        let gaps = recorded_gaps(&metadata).unwrap_or_else(|| rows.gaps());
        let mut capture = Capture {
            source: path.to_owned(),
            axis,
            rate_hz,
            rig: account.into_rig_account(rate_hz),
            gaps,
            models,
            description,
            metadata,
            attachments,
            ..Capture::default()
        };
        rows.store_into(&mut capture);
        let due_s = |tick: &u64| *tick as f64 / rate_hz;
        capture.t_s = capture.tick.iter().map(due_s).collect();
        capture.measured_after_s = capture.measured_after_s.filter(|after| after.iter().any(|after_s| *after_s != 0.0));
        if let Some(after) = &capture.measured_after_s {
            capture.t_s.iter_mut().zip(after).for_each(|(t_s, after_s)| *t_s += after_s);
        }
        Ok(capture)
    }
}

/// The gaps that the writer noted; it also knew what is missing at the end.
pub(crate) fn recorded_gaps(metadata: &BTreeMap<String, BTreeMap<String, String>>) -> Option<Vec<Gap>> {
    serde_json::from_str(metadata.get(GAPS_METADATA)?.get("gaps")?).ok()
}

/// How many samples are missing as the writer counted them, of which the gaps list some.
pub(crate) fn recorded_losses(metadata: &BTreeMap<String, BTreeMap<String, String>>) -> Option<u64> {
    metadata.get(GAPS_METADATA)?.get("missing_samples")?.parse().ok()
}

/// The axis whose names a sample's fields have.
fn axis_of(layout: &Layout) -> Axis {
    let has_load = layout.field(&Axis::Linear.words("torque_mnm")).is_some();
    if has_load { Axis::Linear } else { Axis::Rotary }
}

/// Where the fields of a sample lie, column by column; `None` for one that it does not have.
type SampleFields = Vec<Option<FieldLayout>>;

fn sample_fields(path: &Path, layout: &Layout) -> Result<SampleFields, ArchiveError> {
    let axis = axis_of(layout);
    let find = |column: &Column| match layout.field(column.name_on(axis)) {
        None if column.required => {
            let field = column.name_on(axis);
            Err(ArchiveError::MissingField { path: path.to_owned(), field, found: layout.field_names() })
        }
        field => Ok(field.cloned()),
    };
    columns::of_samples().map(find).collect()
}

/// The columns of the samples as they grow.
struct Rows(Vec<Values<'static>>);

impl Rows {
    fn new() -> Self {
        Self(columns::of_samples().map(|column| (column.empty)()).collect())
    }

    /// Adds a sample; `None` when the message does not hold what its schema says.
    fn push(&mut self, fields: &SampleFields, body: &[u8]) -> Option<()> {
        for (values, field) in self.0.iter_mut().zip(fields) {
            if let Some(field) = field {
                values.push(field, body)?;
            }
        }
        Some(())
    }

    /// Gives a capture the columns that are there. The last sample of a run that ended because a sensor or the apparatus
    /// failed is left out: it shows the fault and has no measurement. So are those without new data from the sensors,
    /// which repeat an earlier one.
    fn store_into(mut self, capture: &mut Capture) {
        let mut kept = vec![true; self.named("seq").map_or(0, Values::len)];
        if let Some(Values::Codes(flags)) = self.named("flags") {
            kept.iter_mut().zip(flags.iter()).for_each(|(kept, flags)| *kept = flags & Sample::STALE == 0);
        }
        let last = |name| self.named(name)?.last();
        let at_fault = last("state") == Some(f64::from(LoopState::Fault.code()));
        // A channel that the rig lacks has no value at all.
        let is_measured =
            |name| self.named(name).is_none_or(|values| !values.has_any() || values.last().is_none_or(f64::is_finite));
        if at_fault
            && !["angle_rad", "torque_mnm", "acceleration_rad_s2", "measured_after_s"].into_iter().all(is_measured)
            && let Some(last) = kept.last_mut()
        {
            *last = false;
        }
        if kept.contains(&false) {
            capture.unmeasured = self.left_out(&kept, capture);
            self.0.iter_mut().for_each(|values| values.keep(&kept));
        }
        for (column, values) in columns::of_samples().zip(self.0) {
            if column.required || values.has_any() {
                (column.store)(capture, values);
            }
        }
    }

    /// The samples that are not kept.
    fn left_out(&self, kept: &[bool], of: &Capture) -> Vec<Sample> {
        let out: Vec<bool> = kept.iter().map(|kept| !kept).collect();
        let mut left = Capture { rate_hz: of.rate_hz, ..Capture::default() };
        for (column, values) in columns::of_samples().zip(&self.0) {
            let mut values = values.clone();
            values.keep(&out);
            if column.required || values.has_any() {
                (column.store)(&mut left, values);
            }
        }
        let run = of.description_or_default();
        (0..left.len()).map(|row| left.sample(row, &run)).collect()
    }

    fn named(&self, name: &str) -> Option<&Values<'static>> {
        columns::of_samples().zip(&self.0).find_map(|(column, values)| (column.name == name).then_some(values))
    }

    fn gaps(&self) -> Vec<Gap> {
        let mut ledger = SequenceLedger::default();
        if let Some(Values::Counts(seq)) = self.named("seq") {
            for &seq in seq.iter() {
                // A repeated sample is found later, by a time that does not rise.
                let _ = ledger.admit(seq);
            }
        }
        ledger.gaps().to_vec()
    }
}
