//! The iceoryx2 services: names, queue depths, history, and how to open them.
//!
//! Every port is made here, so that publisher and subscriber cannot disagree. Whichever process
//! comes first creates a service, the others open it. The payload's layout identity is an
//! attribute of the service: a process built from another definition of the payload gets
//! [`ServiceError::OtherLayout`].
//!
//! When a subscriber dies nothing happens to the publisher; when it comes back, the history of a
//! few seconds that the publisher keeps is delivered to it first. When the publisher dies, its
//! subscribers simply receive nothing more.

use std::fmt::Debug;

use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::port::client::Client;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::server::Server;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{LogLevel, SignalHandlingMode, ZeroCopySend, set_log_level_from_env_or};
use iceoryx2::service::attribute::AttributeVerifier;
use iceoryx2::service::builder::publish_subscribe::{PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError};
use iceoryx2::service::builder::request_response::{RequestResponseOpenError, RequestResponseOpenOrCreateError};

use crate::private_ipc::PrivateIpc;
use crate::shared_memory_dir::Held;
use crate::wire::WireMessage;
use crate::{
    BlockHeader, ControlRequest, ControlResponse, FitUpdate, LoopStatus, MODEL_MAX_BYTES, ProcessHealth, Sample,
    shared_memory, shared_memory_dir,
};

/// Most samples in one block: 1.6 ms at 20 kHz.
pub const SAMPLES_PER_BLOCK: usize = 32;
/// Blocks kept for a subscriber that comes later: about 8 s, since a block is sent every millisecond. A consumer that hangs is
/// noticed, ended and brought back in half of it, a busy machine included.
pub const SAMPLE_HISTORY_BLOCKS: usize = 8192;
/// Blocks that a stalled subscriber may leave waiting: about 16 s. Then the oldest go first.
pub const SAMPLE_QUEUE_BLOCKS: usize = 16384;
/// Longest run description, bytes of JSON.
pub const DESCRIPTION_MAX_BYTES: usize = 64 * 1024;
/// Longest [`ModelChange`](crate::ModelChange) or [`ModelAnswer`](crate::ModelAnswer), bytes of JSON: a line break or a
/// quotation mark of the model takes two.
pub const MODEL_MESSAGE_MAX_BYTES: usize = 2 * MODEL_MAX_BYTES + 1024;
/// Models kept for a subscriber that comes later; they follow each other by a quarter of a second at least.
const MODEL_HISTORY: usize = 32;
/// Consumers that can follow a rig at once.
const MAX_CONSUMERS: usize = 6;
/// Processes that can be attached to a rig at once.
const MAX_NODES: usize = 16;

/// Our kind of iceoryx2 node: between processes, for a single thread.
pub type RigNode = Node<PrivateIpc>;
/// Sends blocks of samples.
pub type SamplePublisher = Publisher<PrivateIpc, [Sample], BlockHeader>;
/// Receives blocks of samples.
pub type SampleSubscriber = Subscriber<PrivateIpc, [Sample], BlockHeader>;
/// Sends single messages of one kind.
pub type MessagePublisher<Payload> = Publisher<PrivateIpc, Payload, ()>;
/// Receives single messages of one kind.
pub type MessageSubscriber<Payload> = Subscriber<PrivateIpc, Payload, ()>;
/// Asks the control loop.
pub type ControlClient = Client<PrivateIpc, ControlRequest, (), ControlResponse, ()>;
/// Answers for the control loop.
pub type ControlServer = Server<PrivateIpc, ControlRequest, (), ControlResponse, ()>;

/// Sends texts.
pub type TextPublisher = Publisher<PrivateIpc, [u8], ()>;
/// Receives texts.
pub type TextSubscriber = Subscriber<PrivateIpc, [u8], ()>;
/// Sends models to the control loop.
pub type ModelClient = Client<PrivateIpc, [u8], (), [u8], ()>;
/// Takes models for the control loop.
pub type ModelServer = Server<PrivateIpc, [u8], (), [u8], ()>;

/// Why a port could not be had.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// The running processes were built from another definition of the payload.
    #[error(
        "the stream '{service}' that is running on this rig was built with another payload layout than this program's \
         ({layout:016x}): stop the running capture, or use programs of the same build"
    )]
    OtherLayout {
        /// Service name.
        service: &'static str,
        /// Layout identity of this program's payload.
        layout: u64,
    },
    /// As many processes as the service allows are attached.
    #[error("'{service}' has no slot left for another process; stop one that follows the rig")]
    Full {
        /// Service name.
        service: &'static str,
    },
    /// iceoryx2 could not give the service or port.
    #[error("shared memory for '{service}' cannot be used ({reason}); {remedy}")]
    Unavailable {
        /// Service name.
        service: &'static str,
        /// iceoryx2's word for it.
        reason: String,
        /// What to do.
        remedy: &'static str,
    },
    /// There is not as much shared memory left as a run can come to need.
    #[error(
        "a run needs {} MB of shared memory and there are {} MB free in /dev/shm; remove files from it, or enlarge it",
        needed.div_ceil(1_000_000),
        free / 1_000_000
    )]
    NoRoom {
        /// What is needed in all, bytes.
        needed: u64,
        /// What is free, bytes.
        free: u64,
    },
    /// The runtime directory or the rig's folder in shared memory cannot be used.
    #[error(transparent)]
    RuntimeDirectory(#[from] std::io::Error),
}

/// A service that carries single messages of one kind.
#[derive(Debug)]
pub struct Topic<Payload> {
    name: &'static str,
    history: usize,
    queue: usize,
    max_publishers: usize,
    payload: std::marker::PhantomData<Payload>,
}

/// Health of the control loop, ten times a second.
pub const LOOP_STATUS: Topic<LoopStatus> = Topic::new("loop-status", 1, 64, 1);
/// The model fitted so far, at 20 Hz or more.
pub const FIT_UPDATES: Topic<FitUpdate> = Topic::new("fit-updates", 128, 512, 2);
/// Health of the consumers, twice a second each.
pub const PROCESS_HEALTH: Topic<ProcessHealth> = Topic::new("process-health", 1, 64, MAX_CONSUMERS);

const SAMPLES: &str = "samples";
const CONTROL: &str = "control";
const MODEL_EXCHANGE: &str = "model-exchange";

impl<Payload> Topic<Payload> {
    const fn new(name: &'static str, history: usize, queue: usize, max_publishers: usize) -> Self {
        Self { name, history, queue, max_publishers, payload: std::marker::PhantomData }
    }
}

impl<Payload: WireMessage + ZeroCopySend + Debug + Copy + 'static> Topic<Payload> {
    /// A port that sends this topic's messages.
    ///
    /// # Errors
    /// [`ServiceError`] when the layout differs, the service is full or shared memory is not available.
    pub fn publisher(&self, node: &RigNode) -> Result<MessagePublisher<Payload>, ServiceError> {
        port(self.name, self.service(node)?.publisher_builder().create())
    }

    /// A port that receives this topic's messages, those in the history first.
    ///
    /// # Errors
    /// [`ServiceError`] when the layout differs, the service is full or shared memory is not available.
    pub fn subscriber(&self, node: &RigNode) -> Result<MessageSubscriber<Payload>, ServiceError> {
        port(self.name, self.service(node)?.subscriber_builder().create())
    }

    fn service(
        &self,
        node: &RigNode,
    ) -> Result<iceoryx2::service::port_factory::publish_subscribe::PortFactory<PrivateIpc, Payload, ()>, ServiceError>
    {
        node.service_builder(&service_name(self.name)?)
            .publish_subscribe::<Payload>()
            .history_size(self.history)
            .subscriber_max_buffer_size(self.queue)
            .max_publishers(self.max_publishers)
            .max_subscribers(MAX_CONSUMERS)
            .max_nodes(MAX_NODES)
            .enable_safe_overflow(true)
            .open_or_create_with_attributes(&layout_attribute(self.name, Payload::layout_id())?)
            .map_err(|error| open_error(self.name, Payload::layout_id(), error))
    }
}

/// Attaches the calling process to the rig, clearing away what dead processes left.
///
/// # Errors
/// [`ServiceError::RuntimeDirectory`], [`ServiceError::NoRoom`] or [`ServiceError::Unavailable`] when the runtime directory or shared memory
/// cannot be used.
pub fn attach(process_name: &str) -> Result<RigNode, ServiceError> {
    // What it warns of, such as what a killed process left behind, is in order here; `IOX2_LOG_LEVEL` asks for more.
    set_log_level_from_env_or(LogLevel::Error);
    shared_memory::check_any_room()?;
    let name = process_name.try_into().map_err(|error| unavailable("node", &error))?;
    // Held until the node is there: until then a clean-up would take its folder for left behind.
    let held = shared_memory_dir::hold()?;
    let node = NodeBuilder::new()
        .name(&name)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .config(&config(&held)?)
        .create::<PrivateIpc>()
        .map_err(|error| unavailable("node", &error))?;
    drop(held);
    node.try_cleanup_dead_nodes();
    Ok(node)
}

/// iceoryx2's configuration for this rig: everything in the rig's own folder.
fn config(held: &Held) -> Result<Config, ServiceError> {
    let mut config = Config::default();
    let directory = shared_memory_dir::create(held)?;
    let root = directory.to_string_lossy().as_ref().try_into().map_err(|error| unavailable("shared memory", &error))?;
    config.global.set_root_path(&root);
    Ok(config)
}

/// The port that sends blocks of up to [`SAMPLES_PER_BLOCK`] samples.
///
/// # Errors
/// [`ServiceError`] when the layout differs, another loop publishes, or shared memory is not available.
pub fn sample_publisher(node: &RigNode) -> Result<SamplePublisher, ServiceError> {
    port(SAMPLES, sample_service(node)?.publisher_builder().initial_max_slice_len(SAMPLES_PER_BLOCK).create())
}

/// A port that receives blocks of samples, up to [`SAMPLE_HISTORY_BLOCKS`] past ones first.
///
/// # Errors
/// [`ServiceError`] when the layout differs, the service is full or shared memory is not available.
pub fn sample_subscriber(node: &RigNode) -> Result<SampleSubscriber, ServiceError> {
    port(SAMPLES, sample_service(node)?.subscriber_builder().create())
}

fn sample_service(
    node: &RigNode,
) -> Result<
    iceoryx2::service::port_factory::publish_subscribe::PortFactory<PrivateIpc, [Sample], BlockHeader>,
    ServiceError,
> {
    node.service_builder(&service_name(SAMPLES)?)
        .publish_subscribe::<[Sample]>()
        .user_header::<BlockHeader>()
        .history_size(SAMPLE_HISTORY_BLOCKS)
        .subscriber_max_buffer_size(SAMPLE_QUEUE_BLOCKS)
        .max_publishers(1)
        .max_subscribers(MAX_CONSUMERS)
        .max_nodes(MAX_NODES)
        .enable_safe_overflow(true)
        .open_or_create_with_attributes(&layout_attribute(SAMPLES, Sample::layout_id())?)
        .map_err(|error| open_error(SAMPLES, Sample::layout_id(), error))
}

/// A service that carries texts of one publisher, the newest of them kept for whoever comes later.
#[derive(Debug)]
pub struct TextTopic {
    name: &'static str,
    longest_bytes: usize,
    history: usize,
    queue: usize,
}

/// What a run is: a [`RunDescription`](crate::RunDescription) as JSON.
pub const RUN_DESCRIPTION: TextTopic =
    TextTopic { name: "run-description", longest_bytes: DESCRIPTION_MAX_BYTES, history: 1, queue: 2 };
/// Each model that begins to be felt: a [`ModelChange`](crate::ModelChange) as JSON.
pub const MODEL_CHANGES: TextTopic =
    TextTopic { name: "models", longest_bytes: MODEL_MESSAGE_MAX_BYTES, history: MODEL_HISTORY, queue: MODEL_HISTORY };

impl TextTopic {
    /// The port that sends this topic's texts.
    ///
    /// # Errors
    /// [`ServiceError`] when the service is full or shared memory is not available.
    pub fn publisher(&self, node: &RigNode) -> Result<TextPublisher, ServiceError> {
        port(self.name, self.service(node)?.publisher_builder().initial_max_slice_len(self.longest_bytes).create())
    }

    /// A port that receives this topic's texts, those in the history first.
    ///
    /// # Errors
    /// [`ServiceError`] when the service is full or shared memory is not available.
    pub fn subscriber(&self, node: &RigNode) -> Result<TextSubscriber, ServiceError> {
        port(self.name, self.service(node)?.subscriber_builder().create())
    }

    fn service(
        &self,
        node: &RigNode,
    ) -> Result<iceoryx2::service::port_factory::publish_subscribe::PortFactory<PrivateIpc, [u8], ()>, ServiceError>
    {
        node.service_builder(&service_name(self.name)?)
            .publish_subscribe::<[u8]>()
            .history_size(self.history)
            .subscriber_max_buffer_size(self.queue)
            .max_publishers(1)
            .max_subscribers(MAX_CONSUMERS)
            .max_nodes(MAX_NODES)
            .open_or_create()
            .map_err(|error| open_error(self.name, 0, error))
    }
}

/// The port through which models are sent to the control loop: a [`ModelRequest`](crate::ModelRequest) as JSON, its model of at
/// most [`MODEL_MAX_BYTES`].
///
/// # Errors
/// [`ServiceError`] when shared memory is not available.
pub fn model_client(node: &RigNode) -> Result<ModelClient, ServiceError> {
    let exchange = model_exchange(node)?;
    port(MODEL_EXCHANGE, exchange.client_builder().initial_max_slice_len(MODEL_MESSAGE_MAX_BYTES).create())
}

/// The port through which the control loop takes models; its answers are a
/// [`ModelAnswer`](crate::ModelAnswer) as JSON.
///
/// # Errors
/// [`ServiceError`] when shared memory is not available.
pub fn model_server(node: &RigNode) -> Result<ModelServer, ServiceError> {
    let exchange = model_exchange(node)?;
    port(MODEL_EXCHANGE, exchange.server_builder().initial_max_slice_len(MODEL_MESSAGE_MAX_BYTES).create())
}

type ModelExchange = iceoryx2::service::port_factory::request_response::PortFactory<PrivateIpc, [u8], (), [u8], ()>;

fn model_exchange(node: &RigNode) -> Result<ModelExchange, ServiceError> {
    node.service_builder(&service_name(MODEL_EXCHANGE)?)
        .request_response::<[u8], [u8]>()
        .max_servers(1)
        .max_clients(4)
        .max_nodes(MAX_NODES)
        .open_or_create()
        .map_err(|error| unavailable(MODEL_EXCHANGE, &error))
}

/// The port through which the control loop is asked.
///
/// # Errors
/// [`ServiceError`] when the layout differs or shared memory is not available.
pub fn control_client(node: &RigNode) -> Result<ControlClient, ServiceError> {
    port(CONTROL, control_service(node)?.client_builder().create())
}

/// The port through which the control loop answers.
///
/// # Errors
/// [`ServiceError`] when the layout differs or shared memory is not available.
pub fn control_server(node: &RigNode) -> Result<ControlServer, ServiceError> {
    port(CONTROL, control_service(node)?.server_builder().create())
}

fn control_service(
    node: &RigNode,
) -> Result<
    iceoryx2::service::port_factory::request_response::PortFactory<PrivateIpc, ControlRequest, (), ControlResponse, ()>,
    ServiceError,
> {
    let layout = ControlRequest::layout_id() ^ ControlResponse::layout_id();
    node.service_builder(&service_name(CONTROL)?)
        .request_response::<ControlRequest, ControlResponse>()
        .max_servers(1)
        .max_clients(4)
        .max_nodes(MAX_NODES)
        .open_or_create_with_attributes(&layout_attribute(CONTROL, layout)?)
        .map_err(|error| match error {
            RequestResponseOpenOrCreateError::RequestResponseOpenError(
                RequestResponseOpenError::IncompatibleAttributes
                | RequestResponseOpenError::IncompatibleRequestOrResponseType,
            ) => ServiceError::OtherLayout { service: CONTROL, layout },
            other => unavailable(CONTROL, &other),
        })
}

fn service_name(name: &'static str) -> Result<iceoryx2::service::service_name::ServiceName, ServiceError> {
    format!("haptic-camera/{name}").as_str().try_into().map_err(|error| unavailable(name, &error))
}

fn layout_attribute(service: &'static str, layout: u64) -> Result<AttributeVerifier, ServiceError> {
    let key = "layout".try_into().map_err(|error| unavailable(service, &error))?;
    let value = format!("{layout:016x}").as_str().try_into().map_err(|error| unavailable(service, &error))?;
    AttributeVerifier::new().require(&key, &value).map_err(|error| unavailable(service, &error))
}

fn open_error(service: &'static str, layout: u64, error: PublishSubscribeOpenOrCreateError) -> ServiceError {
    use PublishSubscribeOpenError as Open;
    match error {
        PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(
            Open::IncompatibleTypes | Open::IncompatibleAttributes,
        ) => ServiceError::OtherLayout { service, layout },
        PublishSubscribeOpenOrCreateError::PublishSubscribeOpenError(Open::ExceedsMaxNumberOfNodes) => {
            ServiceError::Full { service }
        }
        other => unavailable(service, &other),
    }
}

/// A port that was made, after reserving every page that it can come to need: a write to a missing page would end the process.
fn port<Port, Error: Debug>(service: &'static str, made: Result<Port, Error>) -> Result<Port, ServiceError> {
    let port = made.map_err(|error| match format!("{error:?}") {
        reason if reason.starts_with("ExceedsMaxSupported") => ServiceError::Full { service },
        _ => unavailable(service, &error),
    })?;
    shared_memory::reserve()?;
    Ok(port)
}

pub(crate) fn unavailable(service: &'static str, error: &dyn Debug) -> ServiceError {
    ServiceError::Unavailable { service, reason: format!("{error:?}"), remedy: shared_memory::remedy() }
}
