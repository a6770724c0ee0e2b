//! `capability` and `gauge`: what many units, operators and repeats tell.

mod capability;
mod gauge;
mod values;

pub use capability::{CapabilityOptions, run as run_capability};
pub use gauge::{GaugeOptions, run as run_gauge};
