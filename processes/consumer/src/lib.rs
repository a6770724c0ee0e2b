//! What all consumers of the sample stream share: an orderly stop and health reports.
//!
//! A consumer may crash, hang, be killed or be restarted at any moment; the control loop does not
//! notice. It ends with the process that started it, by its [lease](shared_types::lease); signals are left to that
//! process, unless an operator started the consumer.

mod arrivals;
mod health;
mod priority;
mod run;
mod source;
mod stop;

pub use health::Health;
pub use priority::raise_priority;
pub use run::wait_for_run;
pub use source::SourceWatch;
pub use stop::{Stop, StopError};
