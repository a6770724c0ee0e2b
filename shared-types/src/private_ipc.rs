//! iceoryx2's communication between processes, with all of it in one folder.

use std::fmt::Debug;

use iceoryx2::prelude::ZeroCopySend;
use iceoryx2::service::ipc;
use iceoryx2_bb_elementary_traits::testing::abandonable::Abandonable;
use iceoryx2_cal::shm_allocator::bump_allocator::BumpAllocator;
use iceoryx2_cal::shm_allocator::pool_allocator::PoolAllocator;
use iceoryx2_cal::{dynamic_storage, resizable_shared_memory, shared_memory, zero_copy_connection};

/// [`ipc::Service`] with its segments as files below the root path of the configuration.
///
/// `ipc::Service` itself makes segments by `shm_open`, which knows no folders. They lie in `/dev/shm`, where every user sees their
/// names, can take the next names before they are used, and can put links in the segments' place.
#[derive(Clone, Debug)]
pub struct PrivateIpc {}

/// Everything of the service but its segments is that of `ipc::Service`.
type Ipc = ipc::Service;

impl iceoryx2::service::Service for PrivateIpc {
    type StaticStorage = <Ipc as iceoryx2::service::Service>::StaticStorage;
    type ConfigSerializer = <Ipc as iceoryx2::service::Service>::ConfigSerializer;
    type PersistentDynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = dynamic_storage::file::Storage<T>;
    type Bag = <Ipc as iceoryx2::service::Service>::Bag;
    type DynamicStorage<T: Debug + Send + Sync + ZeroCopySend + 'static> = dynamic_storage::file::Storage<T>;
    type ServiceNameHasher = <Ipc as iceoryx2::service::Service>::ServiceNameHasher;
    type SharedMemory = shared_memory::file::Memory<PoolAllocator>;
    type ResizableSharedMemory =
        resizable_shared_memory::dynamic::DynamicMemory<PoolAllocator, shared_memory::file::Memory<PoolAllocator>>;
    type Connection = zero_copy_connection::file::Connection;
    type Event = <Ipc as iceoryx2::service::Service>::Event;
    type Monitoring = <Ipc as iceoryx2::service::Service>::Monitoring;
    type Reactor = <Ipc as iceoryx2::service::Service>::Reactor;
    type ArcThreadSafetyPolicy<T: Send + Debug + Abandonable> =
        <Ipc as iceoryx2::service::Service>::ArcThreadSafetyPolicy<T>;
    type BlackboardMgmt<T: Send + Sync + Debug + ZeroCopySend + 'static> = dynamic_storage::file::Storage<T>;
    type BlackboardPayload = shared_memory::file::Memory<BumpAllocator>;
    type UniqueId = <Ipc as iceoryx2::service::Service>::UniqueId;
}

impl iceoryx2::service::internal::ServiceInternal<Self> for PrivateIpc {}
