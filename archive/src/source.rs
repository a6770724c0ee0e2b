//! One file's messages, in order, however broken the file is.

use std::collections::{BTreeMap, HashMap, VecDeque};
use std::io::Read;
use std::ops::Range;
use std::rc::Rc;

use mcap::records::{MessageHeader, Record, op};
use shared_types::wire::CDR_LITTLE_ENDIAN_HEADER;

use crate::channels::{ChannelDefinition, SampleLayout, Schemas};
use crate::description::attachment;
use crate::parse::parse_record;
use crate::records::{Account, IntactRecord, IntactRecords, Unpacked};

/// A channel as a file defines it.
#[derive(Debug)]
pub(crate) struct SourceChannel {
    pub(crate) definition: ChannelDefinition,
    sample_layout: Option<SampleLayout>,
}

/// What a file yields.
#[derive(Debug)]
pub(crate) enum Item {
    Message(SourceMessage),
    Attachment { name: String, media_type: String, log_time: u64, content: Vec<u8> },
    Metadata(mcap::records::Metadata),
}

/// A message; its body lies in the source until the next call.
#[derive(Clone, Debug)]
pub(crate) struct SourceMessage {
    pub(crate) channel: Rc<SourceChannel>,
    pub(crate) header: MessageHeader,
    /// `seq` on the channel of the samples.
    pub(crate) seq: Option<u64>,
    /// `tick`, there too.
    pub(crate) tick: Option<u64>,
    /// False for a message from a chunk that the end of the file cuts off.
    pub(crate) checked: bool,
    body: Range<usize>,
}

/// Reads one file's messages.
pub(crate) struct Source<R> {
    records: IntactRecords<R>,
    schemas: Schemas,
    channels: HashMap<u16, Rc<SourceChannel>>,
    chunk: Vec<u8>,
    waiting: VecDeque<(u8, Range<usize>)>,
    checked: bool,
    last_seq: Option<u64>,
    /// Messages of intact chunks whose channel nothing in the file defines.
    pub(crate) orphans: u64,
}

impl<R: Read> Source<R> {
    pub(crate) fn new(input: R) -> Self {
        Self {
            records: IntactRecords::new(input),
            schemas: Schemas::default(),
            channels: HashMap::new(),
            chunk: Vec::new(),
            waiting: VecDeque::new(),
            checked: true,
            last_seq: None,
            orphans: 0,
        }
    }

    pub(crate) fn account(&self) -> Account {
        self.records.account()
    }

    /// The bytes of the message that was given last.
    pub(crate) fn body(&self, message: &SourceMessage) -> &[u8] {
        &self.chunk[message.body.clone()]
    }

    /// The next item; `None` at the end of the file.
    pub(crate) fn next(&mut self) -> std::io::Result<Option<Item>> {
        loop {
            while let Some((opcode, place)) = self.waiting.pop_front() {
                if let Some(message) = self.record(opcode, place) {
                    return Ok(Some(Item::Message(message)));
                }
            }
            match self.records.next()? {
                None => return Ok(None),
                Some(IntactRecord::Chunk(unpacked)) => self.open(unpacked, true),
                Some(IntactRecord::UnfinishedChunk(unpacked)) => self.open(unpacked, false),
                Some(IntactRecord::Metadata(metadata)) => return Ok(Some(Item::Metadata(metadata))),
                Some(IntactRecord::Attachment { name, media_type, log_time, content }) => {
                    if name == attachment::CHANNELS {
                        self.learn_channels(&content);
                    }
                    return Ok(Some(Item::Attachment { name, media_type, log_time, content }));
                }
            }
        }
    }

    fn open(&mut self, unpacked: Unpacked, checked: bool) {
        self.chunk = unpacked.bytes;
        self.waiting = unpacked.records.into();
        self.checked = checked;
    }

    /// Takes up a record of the open chunk; gives messages back.
    fn record(&mut self, opcode: u8, place: Range<usize>) -> Option<SourceMessage> {
        // A schema or channel from a chunk without checksum could rename what follows.
        let defines = self.checked && matches!(opcode, op::SCHEMA | op::CHANNEL);
        if opcode != op::MESSAGE && !defines {
            return None;
        }
        match parse_record(opcode, &self.chunk[place.clone()]) {
            Ok(Record::Schema { header, data }) => self.schemas.learn(header, &data),
            Ok(Record::Channel(channel)) => {
                let id = channel.id;
                if let Some(definition) = self.schemas.define(channel) {
                    self.define(id, definition);
                }
            }
            Ok(Record::Message { header, data }) => {
                let start = place.end - data.len();
                return self.message(header, start..place.end);
            }
            _ => {}
        }
        None
    }

    fn message(&mut self, header: MessageHeader, body: Range<usize>) -> Option<SourceMessage> {
        let Some(channel) = self.channels.get(&header.channel_id).cloned() else {
            self.orphans += 1;
            return None;
        };
        let (mut seq, mut tick) = (None, None);
        if let Some(SampleLayout { seq: seq_field, tick: tick_field, size }) = &channel.sample_layout
            && let Some(bytes) = self.chunk[body.clone()].strip_prefix(&CDR_LITTLE_ENDIAN_HEADER)
            && size.is_none_or(|size| bytes.len() == size)
        {
            seq = seq_field.as_u64(bytes);
            tick = tick_field.as_ref().and_then(|field| field.as_u64(bytes));
        }
        if !self.checked {
            // Only the order of `seq` vouches for these messages: stop at the first one that does not continue it.
            let follows = seq.is_some() && self.last_seq.is_some_and(|last| seq == last.checked_add(1));
            if !follows {
                self.waiting.clear();
                return None;
            }
        }
        self.last_seq = seq.or(self.last_seq);
        Some(SourceMessage { channel, header, seq, tick, checked: self.checked, body })
    }

    fn define(&mut self, id: u16, definition: ChannelDefinition) {
        let sample_layout = definition.sample_layout();
        self.channels.insert(id, Rc::new(SourceChannel { definition, sample_layout }));
    }

    fn learn_channels(&mut self, content: &[u8]) {
        let known: BTreeMap<u16, ChannelDefinition> = serde_json::from_slice(content).unwrap_or_default();
        for (id, definition) in known {
            if !self.channels.contains_key(&id) {
                self.define(id, definition);
            }
        }
    }
}
