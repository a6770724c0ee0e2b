//! The simulated rig: a motor, a torque sensor, a gripper and any knob, with the sensors' limits.
//!
//! ```text
//!  command ─► amplifier ─► winding ─► rotor ══ torque sensor ══ gripper + knob
//!             (watchdog)              encoder                   accelerometer
//! ```
//!
//! [`SimulatedRig`] is an [`Apparatus`](crate::Apparatus) like any other. Time is what the caller
//! says it is: each [`read`](SimulatedRig::read) carries the plant from the last reading to the
//! new one in fixed substeps counted from the first reading, so that a control loop can run it
//! against the clock and an offline run as fast as the processor goes, with the same numbers. A
//! seed fixes the noise bit for bit.
//!
//! The knob is a [`dynamics::Model`] with any effects. Inertia, free torques, friction and stick act on the gripper's side of the
//! torque sensor, behind backlash or a compliant shaft if the model has them; effects on the torque sensor's reading are added to the
//! reading. The rig integrates all of it by its own means. [`RigParameters`] holds what the rig is made of; the calibration in its
//! description holds what the rig measured about itself.
//!
//! ```
//! use hal::Apparatus;
//! use hal::simulated_rig::{RigParameters, SimulatedRig};
//!
//! let knob = dynamics::knobs::paper_knob(3)?;
//! let mut rig = SimulatedRig::new(RigParameters::default(), knob, 7)?;
//! rig.enable()?;
//! for tick in 0..1000 {
//!     let measurement = rig.read(tick * 100_000)?; // 10 kHz
//!     rig.write_torque(200.0 * (0.1 - measurement.angle_rad))?;
//! }
//! assert!(rig.truth().knob_angle_rad > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod artefacts;
mod bristles;
mod cogging;
mod contact;
mod description;
mod drive;
mod hand;
mod inner;
mod knob;
mod noise;
mod parameters;
mod plant;
mod rig;
mod sensors;
mod shaft;
mod switch;
mod watchdog;

pub use cogging::{Cogging, CoggingError};
pub use hand::{Grip, Hand, Intention};
pub use parameters::{ParameterError, RigParameters};
pub use plant::Truth;
pub use rig::SimulatedRig;
pub use sensors::Readings;
pub use switch::Switch;

/// The rig file of the simulated rig, which ships.
pub const RIG_FILE: &str = include_str!("rig.toml");

/// The rig file of a simulated rig that presses, which ships too.
pub const LINEAR_RIG_FILE: &str = include_str!("linear-rig.toml");
