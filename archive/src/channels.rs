//! The channels of a capture and how they are identified.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{Seek, Write};

use serde::{Deserialize, Serialize};
use shared_types::wire::WireMessage;
use shared_types::{Axis, FitUpdate, LoopStatus, ModelChange, ProcessHealth, Sample};

use crate::schema::{FieldLayout, Layout};

/// Topic of the samples.
pub(crate) const SAMPLE_TOPIC: &str = "/sample";
/// Topic of the live fitter's estimates.
pub(crate) const FIT_TOPIC: &str = "/fit";
/// Topic of the control loop's status.
pub(crate) const STATUS_TOPIC: &str = "/status";
/// Topic of the consumers' health.
pub(crate) const HEALTH_TOPIC: &str = "/health";
/// Topic of the models that a replay begins to render.
pub(crate) const MODELS_TOPIC: &str = "/models";

/// More channels than any archive has.
const MOST_CHANNELS: usize = 1024;
/// Most bytes that schemas, and the channels with their copies of them, may have together.
const MOST_BYTES: usize = 64 << 20;

/// Encoding of the schemas: the message definition language of ROS 2.
const SCHEMA_ENCODING: &str = "ros2msg";
/// Encoding of the messages: plain CDR with its four-byte header.
const MESSAGE_ENCODING: &str = "cdr";

/// What a channel holds.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct ChannelDefinition {
    pub(crate) topic: String,
    pub(crate) message_encoding: String,
    pub(crate) metadata: BTreeMap<String, String>,
    pub(crate) schema_name: String,
    pub(crate) schema_encoding: String,
    pub(crate) schema_text: String,
}

/// Where the fields lie that tell samples apart.
#[derive(Debug)]
pub(crate) struct SampleLayout {
    pub(crate) seq: FieldLayout,
    pub(crate) tick: Option<FieldLayout>,
    /// Bytes of a message without its header; `None` where that varies.
    pub(crate) size: Option<usize>,
}

/// The schemas and channels that a file has named so far.
#[derive(Default)]
pub(crate) struct Schemas {
    known: HashMap<u16, Schema>,
    defined: HashSet<u16>,
    /// Size of all that is known and defined.
    bytes: usize,
}

#[derive(Clone, Default, PartialEq)]
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

impl Schemas {
    /// Takes note of a schema, up to a bound on all of them together.
    pub(crate) fn learn(&mut self, header: mcap::records::SchemaHeader, data: &[u8]) {
        let schema =
            Schema { name: header.name, encoding: header.encoding, text: String::from_utf8_lossy(data).into_owned() };
        if self.known.get(&header.id) != Some(&schema) && self.take_room(schema.bytes()) {
            self.known.insert(header.id, schema);
        }
    }

    /// Defines a channel and gives its definition. `None` if the channel exceeds the bounds, or was defined before: files repeat definitions.
    pub(crate) fn define(&mut self, channel: mcap::records::Channel) -> Option<ChannelDefinition> {
        let schema = self.known.get(&channel.schema_id).cloned();
        let is_complete = schema.is_some() || channel.schema_id == 0;
        let schema = schema.unwrap_or_default();
        let metadata: usize = channel.metadata.iter().map(|(key, value)| key.len() + value.len()).sum();
        let bytes = schema.bytes() + channel.topic.len() + metadata;
        if self.defined.contains(&channel.id) || self.defined.len() >= MOST_CHANNELS || !self.take_room(bytes) {
            return None;
        }
        // A channel that comes before its schema is defined once more when it comes again.
        if is_complete {
            self.defined.insert(channel.id);
        }
        let Schema { name, encoding, text } = schema;
        Some(ChannelDefinition {
            topic: channel.topic,
            message_encoding: channel.message_encoding,
            metadata: channel.metadata,
            schema_name: name,
            schema_encoding: encoding,
            schema_text: text,
        })
    }

    /// Counts so many bytes more, if there is room for them.
    fn take_room(&mut self, bytes: usize) -> bool {
        let room = self.bytes + bytes <= MOST_BYTES;
        self.bytes += if room { bytes } else { 0 };
        room
    }
}

impl Schema {
    fn bytes(&self) -> usize {
        self.name.len() + self.encoding.len() + self.text.len()
    }
}

impl ChannelDefinition {
    fn of<Payload: WireMessage>(topic: &str, axis: Axis) -> Self {
        Self::with_schema(topic, Payload::SCHEMA_NAME, axis.words(&Payload::schema_text()).into_owned())
    }

    fn with_schema(topic: &str, name: &str, text: String) -> Self {
        Self {
            topic: topic.to_owned(),
            message_encoding: MESSAGE_ENCODING.to_owned(),
            metadata: BTreeMap::new(),
            schema_name: name.to_owned(),
            schema_encoding: SCHEMA_ENCODING.to_owned(),
            schema_text: text,
        }
    }

    /// The channels of a capture that this program writes; their fields have the names of its axis.
    pub(crate) fn all(axis: Axis) -> [Self; 5] {
        [
            Self::of::<Sample>(SAMPLE_TOPIC, axis),
            Self::of::<FitUpdate>(FIT_TOPIC, axis),
            Self::of::<LoopStatus>(STATUS_TOPIC, axis),
            Self::of::<ProcessHealth>(HEALTH_TOPIC, axis),
            Self::with_schema(MODELS_TOPIC, ModelChange::SCHEMA_NAME, ModelChange::SCHEMA_TEXT.to_owned()),
        ]
    }

    /// True for the channel of the samples.
    pub(crate) fn holds_samples(&self) -> bool {
        self.is_ours(SAMPLE_TOPIC)
    }

    /// True for the channel of the rendered models.
    pub(crate) fn holds_models(&self) -> bool {
        self.is_ours(MODELS_TOPIC)
    }

    fn is_ours(&self, topic: &str) -> bool {
        self.topic == topic && self.schema_encoding == SCHEMA_ENCODING && self.message_encoding == MESSAGE_ENCODING
    }

    /// Where `seq` and `tick` lie, on the channel of the samples.
    pub(crate) fn sample_layout(&self) -> Option<SampleLayout> {
        if !self.holds_samples() {
            return None;
        }
        let layout = Layout::parse(&self.schema_text).ok()?;
        let [seq, tick] = ["seq", "tick"].map(|name| layout.field(name).cloned());
        Some(SampleLayout { seq: seq?, tick, size: layout.size })
    }

    /// Adds schema and channel to `mcap`; the id that its messages carry.
    pub(crate) fn register<W: Write + Seek>(&self, mcap: &mut mcap::Writer<W>) -> mcap::McapResult<u16> {
        let Self { topic, message_encoding, metadata, schema_name, schema_encoding, schema_text } = self;
        let schema = if schema_encoding.is_empty() && schema_name.is_empty() {
            0
        } else {
            mcap.add_schema(schema_name, schema_encoding, schema_text.as_bytes())?
        };
        mcap.add_channel(schema, topic, message_encoding, metadata)
    }
}
