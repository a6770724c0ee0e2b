//! The apparatus that turns a knob, real or simulated.
//!
//! [`Apparatus`] is what the control loop needs of a rig: read the sensors, write a torque, switch
//! the amplifier on and off, say what failed. [`Calibration`](dynamics::Calibration) is what is known of the rig from
//! measurement; [`Limits`] is what it must not exceed. [`simulated`] has a rig that needs no hardware.

mod apparatus;
pub mod simulated;

pub use apparatus::{Apparatus, ApparatusError, Limits, Measurement, RigDescription};
