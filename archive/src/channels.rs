//! The channels of a capture and how they are told apart.

use std::collections::{BTreeMap, HashMap};
use std::io::{Seek, Write};

use serde::{Deserialize, Serialize};
use shared_types::wire::WireMessage;
use shared_types::{FitUpdate, LoopStatus, ModelChange, ProcessHealth, Sample};

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

/// The schemas that a file has named so far, and so what its channels hold.
#[derive(Default)]
pub(crate) struct Schemas(HashMap<u16, Schema>);

#[derive(Clone, Default)]
struct Schema {
    name: String,
    encoding: String,
    text: String,
}

impl Schemas {
    /// Takes note of a schema.
    pub(crate) fn learn(&mut self, header: mcap::records::SchemaHeader, data: &[u8]) {
        let text = String::from_utf8_lossy(data).into_owned();
        self.0.insert(header.id, Schema { name: header.name, encoding: header.encoding, text });
    }

    /// What a channel holds; without a schema if the file has not named it.
    pub(crate) fn define(&self, channel: mcap::records::Channel) -> ChannelDefinition {
        let Schema { name, encoding, text } = self.0.get(&channel.schema_id).cloned().unwrap_or_default();
        ChannelDefinition {
            topic: channel.topic,
            message_encoding: channel.message_encoding,
            metadata: channel.metadata,
            schema_name: name,
            schema_encoding: encoding,
            schema_text: text,
        }
    }
}

impl ChannelDefinition {
    fn of<Payload: WireMessage>(topic: &str) -> Self {
        Self::with_schema(topic, Payload::SCHEMA_NAME, Payload::schema_text())
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

    /// The channels of a capture that this program writes.
    pub(crate) fn all() -> [Self; 5] {
        [
            Self::of::<Sample>(SAMPLE_TOPIC),
            Self::of::<FitUpdate>(FIT_TOPIC),
            Self::of::<LoopStatus>(STATUS_TOPIC),
            Self::of::<ProcessHealth>(HEALTH_TOPIC),
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
