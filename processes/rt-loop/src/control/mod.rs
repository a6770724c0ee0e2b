//! The control step: state, measurement and tick in; torque and what to record out.
//!
//! Nothing here reads a clock or touches hardware: a recorded run, fed through again, gives the
//! same torques bit for bit.

mod cogging;
mod holding;
mod lowpass;
pub mod rendering;
mod servo;
mod step;
mod tracking;

pub use cogging::CoggingCompensation;
pub use holding::Holding;
pub use servo::ServoGains;
pub(crate) use servo::notch;
pub use step::{ControlPlan, ControlState, Reading, Request, StepOutput};
