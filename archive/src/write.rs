//! Writing a capture while it happens.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use mcap::records::MessageHeader;
use shared_types::wire::{CDR_LITTLE_ENDIAN_HEADER, WireMessage};
use shared_types::{ClockMapping, FitUpdate, LoopStatus, ModelChange, ProcessHealth, RunDescription, Sample};

use crate::channels::ChannelDefinition;
use crate::description;
use crate::error::ArchiveError;
use crate::sequence::SequenceLedger;

/// Uncompressed bytes at which a chunk is closed even if nobody calls for it.
///
/// Half a second at 20 kHz is 1.6 MB; a recorder that catches up on its history writes more at once.
const CHUNK_BYTES: u64 = 2 * 1024 * 1024;
/// zstd's fastest regular level: noise does not compress, and higher levels cost CPU time only.
const COMPRESSION_LEVEL: u32 = 1;

/// How archives are written, wherever they are written.
///
/// A chunk is assembled in memory and written whole, so that a killed process leaves no chunk
/// whose header still awaits its sizes.
pub(crate) fn options() -> mcap::WriteOptions {
    mcap::WriteOptions::new()
        .profile("ros2")
        .library(concat!("haptic-camera ", env!("CARGO_PKG_VERSION")))
        .compression(Some(mcap::Compression::Zstd))
        .compression_level(COMPRESSION_LEVEL)
        .compression_threads(0)
        .chunk_size(Some(CHUNK_BYTES))
        .disable_seeking(true)
}

/// What a finished archive holds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WriteSummary {
    /// Samples written.
    pub samples: u64,
    /// Messages written on all channels, samples included.
    pub messages: u64,
    /// Samples that came and samples that are missing.
    pub ledger: SequenceLedger,
}

/// Writes a capture to any [`Write`] + [`Seek`]; no files are opened here.
///
/// Call [`flush`](Self::flush) at least every half second: what was written before survives the
/// process. Call [`finish`](Self::finish) at the end; dropping the writer hides the error. After
/// any error the writer is dead, and the capture goes on in a new file.
pub struct CaptureWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    clock: ClockMapping,
    channels: [u16; 5],
    /// Log time of each channel's newest message, ns.
    newest_ns: [u64; 5],
    ledger: SequenceLedger,
    messages: u64,
    body: Vec<u8>,
}

impl<W: Write + Seek> std::fmt::Debug for CaptureWriter<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("CaptureWriter").field("ledger", &self.ledger).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> CaptureWriter<W> {
    /// Begins an archive: header, schemas, channels, attachments and the record `capture`.
    ///
    /// # Errors
    /// [`ArchiveError::Write`] when `output` refuses.
    pub fn new(output: W, description: &RunDescription) -> Result<Self, ArchiveError> {
        Self::with_options(output, description, options())
    }

    /// Like [`new`](Self::new), with other compression or chunk sizes; for measuring them.
    ///
    /// # Errors
    /// [`ArchiveError::Write`] when `output` refuses.
    pub fn with_options(output: W, run: &RunDescription, options: mcap::WriteOptions) -> Result<Self, ArchiveError> {
        let mut mcap = options.create(output).map_err(|error| ArchiveError::write(&error))?;
        let mut channels = [0; 5];
        let mut definitions = BTreeMap::new();
        for (id, definition) in channels.iter_mut().zip(ChannelDefinition::all(run.axis)) {
            *id = definition.register(&mut mcap).map_err(|error| ArchiveError::write(&error))?;
            definitions.insert(*id, definition);
        }
        for (name, media_type, content) in description::attachments(run, &definitions)? {
            description::attach(&mut mcap, run.clock.wall_clock_time_ns, name, media_type, &content)
                .map_err(|error| ArchiveError::write(&error))?;
        }
        mcap.write_metadata(&description::capture_metadata(run)).map_err(|error| ArchiveError::write(&error))?;
        Ok(Self {
            mcap,
            clock: run.clock,
            channels,
            newest_ns: [0; 5],
            ledger: SequenceLedger::default(),
            messages: 0,
            body: CDR_LITTLE_ENDIAN_HEADER.to_vec(),
        })
    }

    /// Writes a sample unless it, or a later one, is there already; whether it was written.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn sample(&mut self, sample: &Sample) -> Result<bool, ArchiveError> {
        if !self.ledger.admit(sample.seq) {
            return Ok(false);
        }
        // The message's own number has 32 bits; `seq` in the body has all 64.
        self.message(0, sample.seq as u32, sample.monotonic_time_ns, sample)?;
        Ok(true)
    }

    /// Writes an estimate of the live fitter.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn fit(&mut self, update: &FitUpdate) -> Result<(), ArchiveError> {
        self.message(1, 0, update.monotonic_time_ns, update)
    }

    /// Writes the control loop's status.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn status(&mut self, status: &LoopStatus) -> Result<(), ArchiveError> {
        self.message(2, 0, status.monotonic_time_ns, status)
    }

    /// Writes a consumer's health.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn health(&mut self, health: &ProcessHealth) -> Result<(), ArchiveError> {
        self.message(3, 0, health.monotonic_time_ns, health)
    }

    /// Writes a model that begins to be rendered.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn model(&mut self, change: &ModelChange) -> Result<(), ArchiveError> {
        self.body_bytes(4, 0, change.monotonic_time_ns, &change.cdr_body())
    }

    fn message<Payload: WireMessage>(
        &mut self,
        channel: usize,
        sequence: u32,
        monotonic_time_ns: u64,
        payload: &Payload,
    ) -> Result<(), ArchiveError> {
        self.body_bytes(channel, sequence, monotonic_time_ns, payload.wire_bytes())
    }

    fn body_bytes(
        &mut self,
        channel: usize,
        sequence: u32,
        monotonic_time_ns: u64,
        body: &[u8],
    ) -> Result<(), ArchiveError> {
        self.body.truncate(CDR_LITTLE_ENDIAN_HEADER.len());
        self.body.extend_from_slice(body);
        // Messages of several processes may arrive out of order. Readers expect times within a channel that never fall, so a late
        // message takes the newest one's; in its body it keeps its own.
        let time_ns = self.clock.wall_clock(monotonic_time_ns).max(self.newest_ns[channel]);
        self.newest_ns[channel] = time_ns;
        let header =
            MessageHeader { channel_id: self.channels[channel], sequence, log_time: time_ns, publish_time: time_ns };
        self.mcap.write_to_known_channel(&header, &self.body).map_err(|error| ArchiveError::write(&error))?;
        self.messages += 1;
        Ok(())
    }

    /// Attaches a file, such as a fitted model.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn attach(&mut self, name: &str, media_type: &str, content: &[u8]) -> Result<(), ArchiveError> {
        description::attach(&mut self.mcap, self.clock.wall_clock_time_ns, name, media_type, content)
            .map_err(|error| ArchiveError::write(&error))
    }

    /// Closes the open chunk and hands everything to the operating system.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]; the writer is dead then.
    pub fn flush(&mut self) -> Result<(), ArchiveError> {
        self.mcap.flush().map_err(|error| ArchiveError::write(&error))
    }

    /// Which samples were written so far.
    #[must_use]
    pub fn ledger(&self) -> &SequenceLedger {
        &self.ledger
    }

    /// Takes note that the run published so many samples: those missing at the end are a gap.
    pub fn published(&mut self, samples: u64) {
        self.ledger.close(samples);
    }

    /// Writes the record `gaps` where samples are missing, the index and the end of the file.
    ///
    /// # Errors
    /// [`ArchiveError::Write`]: the file has no end then; what was flushed can be recovered.
    pub fn finish(mut self) -> Result<(WriteSummary, W), ArchiveError> {
        if let Some(gaps) = description::gaps_metadata(&self.ledger)? {
            self.mcap.write_metadata(&gaps).map_err(|error| ArchiveError::write(&error))?;
        }
        self.mcap.finish().map_err(|error| ArchiveError::write(&error))?;
        let summary = WriteSummary { samples: self.ledger.admitted(), messages: self.messages, ledger: self.ledger };
        Ok((summary, self.mcap.into_inner()))
    }
}
