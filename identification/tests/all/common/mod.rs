//! What tests and studies share: captures by formula and from the simulated rig, true values, random numbers.
//!
//! Studies say `#[path = "../tests/all/common/mod.rs"] mod common;`.
#![allow(dead_code, unused_imports, reason = "each test and each study uses its part")]

mod bench;
mod capture;
mod ideal;
mod measured;
mod random;
mod servo;
mod truth;

pub use bench::run;
pub use capture::Capture;
pub use ideal::{ideal, knob, sweep};
pub use measured::{measured, table};
pub use random::Uniform;
pub use servo::{Commanded, captured, captured_at, commanded};
pub use truth::{SLIDING, TABLE_2, true_value};

/// Sample rate of the captures from the simulated rig, Hz.
pub const RATE_HZ: f64 = 10_000.0;

/// What may go wrong in a study.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
