//! Several files' messages into one archive: the core of merging and of recovery.
//!
//! Samples come out in the order of `seq`, each once. Other messages keep their place among the
//! samples of their file; one that several files hold (a restarted recorder receives history)
//! comes out once. Memory holds one chunk per file that is being read.

use std::collections::{BTreeMap, HashMap, HashSet, VecDeque};
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::{Read, Seek, Write};
use std::rc::Rc;

use mcap::records::MessageHeader;
use shared_types::RunDescription;

use crate::channels::ChannelDefinition;
use crate::description::{
    CAPTURE_METADATA, GAPS_METADATA, RECOVERY_METADATA, attach, attachment, capture_metadata, gaps_metadata,
};
use crate::error::ArchiveError;
use crate::sequence::{Gap, SequenceLedger};
use crate::source::{Item, Source, SourceChannel, SourceMessage};

/// Messages other than samples that are remembered to recognise their repetition.
const REMEMBERED_MESSAGES: usize = 4096;

/// Writes what the sources yield.
pub(crate) struct Combiner<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    channels: HashMap<*const SourceChannel, (Rc<SourceChannel>, u16)>,
    attached: HashSet<(String, Vec<u8>)>,
    described: HashSet<String>,
    seen: Option<Seen>,
    pub(crate) ledger: SequenceLedger,
    pub(crate) messages: u64,
    pub(crate) run: Option<RunDescription>,
    /// The last gap that a source's own record names.
    noted_gap: Option<Gap>,
}

/// Hashes of the latest messages. The probability that any two of four thousand different messages share a hash is one in 10^12.
#[derive(Default)]
struct Seen {
    order: VecDeque<u64>,
    set: HashSet<u64>,
}

impl Seen {
    /// Remembers a message; true if it was not remembered already.
    fn note(&mut self, topic: &str, body: &[u8]) -> bool {
        let mut hasher = DefaultHasher::new();
        (topic, body).hash(&mut hasher);
        let key = hasher.finish();
        if !self.set.insert(key) {
            return false;
        }
        self.order.push_back(key);
        if self.order.len() > REMEMBERED_MESSAGES
            && let Some(oldest) = self.order.pop_front()
        {
            self.set.remove(&oldest);
        }
        true
    }
}

impl<W: Write + Seek> Combiner<W> {
    /// Begins an archive. With `overlapping` sources, repeated messages come out once.
    pub(crate) fn new(output: W, overlapping: bool) -> Result<Self, ArchiveError> {
        let mcap = crate::write::options().create(output).map_err(|error| ArchiveError::write(&error))?;
        Ok(Self {
            mcap,
            channels: HashMap::new(),
            attached: HashSet::new(),
            described: HashSet::new(),
            seen: overlapping.then(Seen::default),
            ledger: SequenceLedger::default(),
            messages: 0,
            run: None,
            noted_gap: None,
        })
    }

    /// Writes a message with its `body`, unless it was written before.
    pub(crate) fn message(&mut self, message: &SourceMessage, body: &[u8]) -> Result<(), ArchiveError> {
        match message.seq {
            Some(seq) => {
                if !self.ledger.admit(seq) {
                    return Ok(());
                }
            }
            None => {
                if let Some(seen) = &mut self.seen
                    && !seen.note(&message.channel.definition.topic, body)
                {
                    return Ok(());
                }
            }
        }
        let channel_id = self.channel(&message.channel)?;
        let header = MessageHeader { channel_id, ..message.header };
        self.mcap.write_to_known_channel(&header, body).map_err(|error| ArchiveError::write(&error))?;
        self.messages += 1;
        Ok(())
    }

    fn channel(&mut self, channel: &Rc<SourceChannel>) -> Result<u16, ArchiveError> {
        let key = Rc::as_ptr(channel);
        if let Some((_, id)) = self.channels.get(&key) {
            return Ok(*id);
        }
        let id = channel.definition.register(&mut self.mcap).map_err(|error| ArchiveError::write(&error))?;
        // The map keeps the channel alive, so that no other can come to lie at its address.
        self.channels.insert(key, (Rc::clone(channel), id));
        Ok(id)
    }

    /// Writes an attachment once, and the record `capture` with the run's description.
    pub(crate) fn attachment(
        &mut self,
        name: String,
        media_type: &str,
        log_time: u64,
        content: Vec<u8>,
    ) -> Result<(), ArchiveError> {
        if name == attachment::CHANNELS {
            return self.list_channels(&content);
        }
        if self.attached.contains(&(name.clone(), content.clone())) {
            return Ok(());
        }
        attach(&mut self.mcap, log_time, &name, media_type, &content).map_err(|error| ArchiveError::write(&error))?;
        if name == attachment::RUN
            && self.run.is_none()
            && let Ok(run) = serde_json::from_slice::<RunDescription>(&content)
        {
            self.metadata(&capture_metadata(&run))?;
            self.run = Some(run);
        }
        self.attached.insert((name, content));
        Ok(())
    }

    /// Registers the channels that a source lists, and lists them under the ids they have here.
    ///
    /// The list stands before the first sample, so that it is known when a damaged first chunk
    /// is met.
    fn list_channels(&mut self, content: &[u8]) -> Result<(), ArchiveError> {
        let Ok(definitions) = serde_json::from_slice::<BTreeMap<u16, ChannelDefinition>>(content) else {
            return Ok(());
        };
        let mut here = BTreeMap::new();
        for definition in definitions.into_values() {
            let id = definition.register(&mut self.mcap).map_err(|error| ArchiveError::write(&error))?;
            here.insert(id, definition);
        }
        let list = serde_json::to_vec(&here).map_err(|error| ArchiveError::write(&error))?;
        if self.attached.insert((attachment::CHANNELS.to_owned(), list.clone())) {
            let time_ns = self.run.as_ref().map_or(0, |run| run.clock.wall_clock_time_ns);
            attach(&mut self.mcap, time_ns, attachment::CHANNELS, "application/json", &list)
                .map_err(|error| ArchiveError::write(&error))?;
        }
        Ok(())
    }

    /// Writes a metadata record unless one of that name is there.
    pub(crate) fn metadata(&mut self, metadata: &mcap::records::Metadata) -> Result<(), ArchiveError> {
        if self.described.insert(metadata.name.clone()) {
            self.mcap.write_metadata(metadata).map_err(|error| ArchiveError::write(&error))?;
        }
        Ok(())
    }

    /// Takes an attachment or a metadata record.
    pub(crate) fn take_record(&mut self, item: Item) -> Result<(), ArchiveError> {
        match item {
            Item::Message(_) => Ok(()),
            Item::Attachment { name, media_type, log_time, content } => {
                self.attachment(name, &media_type, log_time, content)
            }
            // A metadata record has no checksum; the run's description, which says the same, has one.
            Item::Metadata(metadata) if self.run.is_some() && metadata.name == CAPTURE_METADATA => Ok(()),
            Item::Metadata(metadata) if metadata.name == GAPS_METADATA => {
                let gaps = metadata.metadata.get("gaps").and_then(|text| serde_json::from_str::<Vec<Gap>>(text).ok());
                self.noted_gap = gaps.and_then(|gaps| gaps.last().copied());
                Ok(())
            }
            Item::Metadata(metadata) if metadata.name == RECOVERY_METADATA => Ok(()),
            Item::Metadata(metadata) => self.metadata(&metadata),
        }
    }

    /// Adds the gap at the end of the run that the source's record `gaps` names: its writer knew the number of samples.
    ///
    /// No checksum covers that record, so the gap is added only if it begins right after the last sample.
    pub(crate) fn take_over_noted_gap(&mut self) {
        if let Some(Gap { first_missing_seq, last_missing_seq, count }) = self.noted_gap
            && first_missing_seq == self.ledger.next()
            && Some(count) == last_missing_seq.checked_sub(first_missing_seq).and_then(|more| more.checked_add(1))
        {
            self.ledger.close(last_missing_seq.saturating_add(1));
        }
    }

    /// Writes the record `gaps` and the end of the file.
    pub(crate) fn finish(&mut self) -> Result<(), ArchiveError> {
        if let Some(gaps) = gaps_metadata(&self.ledger)? {
            self.mcap.write_metadata(&gaps).map_err(|error| ArchiveError::write(&error))?;
        }
        self.mcap.finish().map_err(|error| ArchiveError::write(&error))?;
        Ok(())
    }
}

/// Passes everything from one source on to `combiner`, up to the next sample.
///
/// The sample stays with the caller, who decides which source's sample comes first.
pub(crate) fn advance<R: Read, W: Write + Seek>(
    source: &mut Source<R>,
    combiner: &mut Combiner<W>,
    path: &std::path::Path,
) -> Result<Option<SourceMessage>, ArchiveError> {
    loop {
        match source.next().map_err(|error| ArchiveError::file(path, error))? {
            None => return Ok(None),
            Some(Item::Message(message)) if message.seq.is_some() => return Ok(Some(message)),
            Some(Item::Message(message)) => combiner.message(&message, source.body(&message))?,
            Some(record) => combiner.take_record(record)?,
        }
    }
}
