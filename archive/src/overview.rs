//! What a capture is and whether it is whole, without keeping its samples.

use std::collections::HashMap;
use std::path::Path;

use mcap::records::Record;
use shared_types::wire::CDR_LITTLE_ENDIAN_HEADER;
use shared_types::{LoopState, RunDescription};

use crate::capture::Capture;
use crate::channels::Schemas;
use crate::description::{RECOVERY_METADATA, attachment, described_rate_hz};
use crate::error::ArchiveError;
use crate::mcap_file::{read_records, recorded_gaps, recorded_losses};
use crate::parse::parse_record;
use crate::rig_account::{Account, AccountFields, RigAccount};
use crate::schema::{FieldLayout, Layout};
use crate::sequence::{Gap, SequenceLedger};

/// What a capture is and whether it is whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overview {
    /// Samples that are there.
    pub samples: u64,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// From the first tick to the last, s.
    pub duration_s: f64,
    /// Runs of samples that were taken and are not there.
    pub gaps: Vec<Gap>,
    /// Samples that were taken and are not there.
    pub lost_samples: u64,
    /// Ticks that the loop missed; `None` from a table.
    pub missed_ticks: Option<u64>,
    /// How the rig kept up with the ticks.
    pub rig: RigAccount,
    /// Whether the run ended in a fault.
    pub fault: bool,
    /// Whether the archive was made of a broken one.
    pub recovered: bool,
    /// The run's description; `None` from a table.
    pub description: Option<RunDescription>,
}

impl Overview {
    /// Reads a capture from end to end, comparing every checksum, in memory that does not grow with its length.
    ///
    /// # Errors
    /// As [`Capture::load`], one sentence that names the file.
    pub fn read(path: &Path) -> Result<Self, ArchiveError> {
        if !crate::capture::is_mcap(path)? {
            return Capture::load(path).map(|table| Self::of_table(&table));
        }
        let mut content = Content::default();
        read_records(path, |opcode, body| content.record(path, opcode, body))?;
        content.into_overview(path)
    }

    fn of_table(table: &Capture) -> Self {
        let (samples, duration_s) = (table.len() as u64, table.duration_s());
        Self { samples, rate_hz: table.rate_hz, duration_s, ..Self::default() }
    }
}

/// What was read so far.
#[derive(Default)]
struct Content {
    schemas: Schemas,
    channels: HashMap<u16, Fields>,
    ledger: SequenceLedger,
    missed_ticks: u64,
    account: Account,
    first_tick: Option<u64>,
    last_tick: u64,
    last_state: u64,
    metadata: std::collections::BTreeMap<String, std::collections::BTreeMap<String, String>>,
    description: Option<RunDescription>,
}

/// Where the fields lie that the overview is made from.
struct Fields {
    seq: FieldLayout,
    tick: FieldLayout,
    missed_ticks: Option<FieldLayout>,
    state: Option<FieldLayout>,
    account: AccountFields,
}

impl Content {
    fn record(&mut self, path: &Path, opcode: u8, body: &[u8]) -> Result<(), ArchiveError> {
        let damaged = |reason: String| ArchiveError::Damaged { path: path.to_owned(), reason };
        match parse_record(opcode, body).map_err(|error| damaged(error.to_string()))? {
            Record::Schema { header, data } => self.schemas.learn(header, &data),
            Record::Channel(channel) => {
                let channel_id = channel.id;
                if let Some(definition) = self.schemas.define(channel)
                    && definition.holds_samples()
                    && let Some(fields) = Fields::find(path, &definition.schema_text)?
                {
                    self.channels.insert(channel_id, fields);
                }
            }
            Record::Message { header, data } => {
                if let Some(fields) = self.channels.get(&header.channel_id) {
                    let body = data.strip_prefix(&CDR_LITTLE_ENDIAN_HEADER);
                    let numbers = body.and_then(|body| Some((body, fields.numbers(body)?)));
                    let (body, [seq, tick, missed, state]) = numbers.ok_or_else(|| {
                        damaged("a sample is shorter than its schema says, or not little-endian CDR".to_owned())
                    })?;
                    // A repeated sample is counted once.
                    if self.ledger.admit(seq) {
                        self.account.take(&fields.account, body);
                        self.first_tick.get_or_insert(tick);
                        (self.last_tick, self.last_state) = (tick, state);
                        self.missed_ticks += missed;
                    }
                }
            }
            Record::Attachment { header, data, .. } if header.name == attachment::RUN => {
                self.description = serde_json::from_slice(&data).ok();
            }
            Record::Metadata(record) => {
                self.metadata.insert(record.name, record.metadata);
            }
            _ => {}
        }
        Ok(())
    }

    fn into_overview(self, path: &Path) -> Result<Overview, ArchiveError> {
        if self.channels.is_empty() {
            return Err(ArchiveError::NoSamples { path: path.to_owned() });
        }
        let rate_hz = described_rate_hz(self.description.as_ref(), &self.metadata)
            .ok_or_else(|| ArchiveError::NoRate { path: path.to_owned() })?;
        let lost_samples = recorded_losses(&self.metadata).unwrap_or_else(|| self.ledger.missing());
        let gaps = recorded_gaps(&self.metadata).unwrap_or_else(|| self.ledger.gaps().to_vec());
        let ticks = self.first_tick.map_or(0, |first| self.last_tick.saturating_sub(first));
        Ok(Overview {
            samples: self.ledger.admitted(),
            rate_hz,
            duration_s: ticks as f64 / rate_hz,
            gaps,
            lost_samples,
            missed_ticks: Some(self.missed_ticks),
            rig: self.account.into_rig_account(rate_hz),
            fault: self.last_state == u64::from(LoopState::Fault.code()),
            recovered: self.metadata.contains_key(RECOVERY_METADATA),
            description: self.description,
        })
    }
}

impl Fields {
    /// `None` where the samples have no number or tick: they are then no capture of ours.
    fn find(path: &Path, schema_text: &str) -> Result<Option<Self>, ArchiveError> {
        let layout =
            Layout::parse(schema_text).map_err(|error| ArchiveError::Schema { path: path.to_owned(), error })?;
        let [seq, tick, missed_ticks, state] =
            ["seq", "tick", "missed_ticks", "state"].map(|name| layout.field(name).cloned());
        let account = AccountFields::find(&layout);
        Ok(seq.zip(tick).map(|(seq, tick)| Self { seq, tick, missed_ticks, state, account }))
    }

    /// Number, tick, ticks missed before and state; zero for what the samples do not have.
    fn numbers(&self, body: &[u8]) -> Option<[u64; 4]> {
        let optional = |field: &Option<FieldLayout>| field.as_ref().map_or(Some(0), |field| field.as_u64(body));
        Some([self.seq.as_u64(body)?, self.tick.as_u64(body)?, optional(&self.missed_ticks)?, optional(&self.state)?])
    }
}
