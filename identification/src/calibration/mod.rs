//! Calibrating a rig from captures: zeros, gravity, the gripper's inertia, the channels' delays, the motor's cogging and friction.
//!
//! Each calibration takes a capture made for it and the calibration so far, and returns [`Estimate`]s with 95 % intervals:
//!
//! | calibration | the capture | what it tells |
//! |---|---|---|
//! | [`zero`] | nothing on the gripper, no torque, at rest | the readings of torque sensor and accelerometer at rest |
//! | [`gravity`] | a slow turn of more than 360° | gravity in the acceleration signal |
//! | [`latency`] | the gripper alone under fast sines | how late torque and acceleration come |
//! | [`command_latency`] | the same | how late the motor follows its command |
//! | [`gripper`] | the gripper alone under a sweep | its inertia |
//! | [`cogging`] | the gripper alone turned slowly both ways, with what was commanded | the motor's cogging |
//! | [`friction`] | the gripper alone under a sweep, with what was commanded | the motor's inertia and friction |
//!
//! They build on one another in this order. A quantity that a calibration is to find is never corrected in its capture by an
//! earlier value.

mod cogging;
mod combine;
mod estimate;
mod friction;
mod gravity;
mod latency;
mod regression;
mod zero;

pub use cogging::cogging;
pub use combine::combine;
pub use estimate::{CalibrateError, Calibrated, CoggingEstimate, Estimate};
pub(crate) use friction::acting_mnm;
pub use friction::{friction, gripper};
pub use gravity::gravity;
pub use latency::{command_latency, latency};
pub use zero::zero;
