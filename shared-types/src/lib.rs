//! Everything that crosses a process border, defined once.
//!
//! - **Payloads** ([`Sample`], [`FitUpdate`], [`LoopStatus`], [`ProcessHealth`]) are `#[repr(C)]`
//!   structs without padding. Their bytes are at once what lies in shared memory and the body of
//!   a little-endian CDR message; struct and `ros2msg` schema come from one definition
//!   (see [`wire`]), so neither can drift from the other.
//! - **Services** ([`services`]) name the iceoryx2 services, their queue depths and history, and
//!   carry each payload's layout as an attribute: a process built from another definition is
//!   refused with [`ServiceError::OtherLayout`](services::ServiceError) and never reads garbage.
//! - **[`RunDescription`]** is what a consumer must know about a run besides its samples, and
//!   **[`ModelChange`]** tells of each model that a replay begins to render.
//! - **[`Axis`]** says whether a control turns or travels, and **[`Quantity`]** in which units.
//! - **[`rig`]** says where a rig's lock lives, so that rigs do not meet.
//! - **[`shared_memory`]** reserves what a run can come to need of it.
//! - **[`lease`]** ends a process with the one that started it.
//!
//! Services and shared memory are the feature `services`, which is on unless it is declined: whoever only reads archives does
//! without iceoryx2.
//!
//! ```
//! use shared_types::{Sample, wire::WireMessage};
//!
//! let sample = Sample { seq: 7, torque_mnm: -1.5, ..Sample::default() };
//! assert_eq!(sample.wire_bytes().len(), 136);
//! assert!(Sample::schema_text().starts_with("uint64 seq"));
//! ```

#[macro_use]
pub mod wire;

#[cfg(feature = "services")]
pub mod clean_up;
mod command;
mod description;
pub mod fault_injection;
mod fit_update;
mod health;
pub mod lease;
mod model_exchange;
#[cfg(feature = "services")]
mod private_ipc;
pub mod rig;
mod sample;
#[cfg(feature = "services")]
pub mod services;
#[cfg(feature = "services")]
pub mod shared_memory;
#[cfg(feature = "services")]
mod shared_memory_dir;
mod status;

pub use command::{CommandKind, ControlRequest, ControlResponse};
pub use description::{ClockMapping, DescriptionError, RunDescription};
pub use dynamics::{Axis, Quantity};
pub use fit_update::{Convergence, Estimate, FitUpdate, Verdict};
pub use health::{ProcessHealth, ProcessKind};
pub use model_exchange::{MODEL_MAX_BYTES, ModelAnswer, ModelChange, ModelRequest};
#[cfg(feature = "services")]
pub use private_ipc::PrivateIpc;
pub use sample::{BlockHeader, Fault, LoopState, Sample};
pub use status::{LATENESS_BIN_EDGES_NS, LoopStatus, realtime};

/// Conversion between a wire code (`u32`) and the enum it stands for.
macro_rules! wire_code {
    ($(#[doc = $doc:literal])* pub enum $name:ident { $($(#[doc = $vdoc:literal])* $variant:ident = $code:literal,)+ }) => {
        $(#[doc = $doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[repr(u32)]
        pub enum $name { $($(#[doc = $vdoc])* $variant = $code,)+ }

        impl $name {
            /// The number that stands for this on the wire.
            #[must_use]
            pub const fn code(self) -> u32 { self as u32 }

            /// The meaning of a wire code; `None` for a code this version does not know.
            #[must_use]
            pub const fn from_code(code: u32) -> Option<Self> {
                match code { $($code => Some(Self::$variant),)+ _ => None }
            }
        }
    };
}
pub(crate) use wire_code;
