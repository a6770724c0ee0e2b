//! What the studies share: captures from the simulated rig and uniform random numbers.
#![allow(dead_code, reason = "each study uses its part")]

mod random;
mod rig;

#[allow(unused_imports, reason = "each study uses its part")]
pub use random::Uniform;
#[allow(unused_imports, reason = "each study uses its part")]
pub use rig::{RATE_HZ, RigCapture, capture, true_value};
