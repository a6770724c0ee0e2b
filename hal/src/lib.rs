//! The apparatus that turns a knob, real or simulated.
//!
//! [`Apparatus`] is what the control loop needs of a rig: bring it up, exchange torque and measurement, switch the amplifier on
//! and off, say what failed. [`Calibration`](dynamics::Calibration) is what is known of the rig from measurement; [`Limits`] is
//! what it must not exceed. A [`RigFile`] names the driver and all that a lab knows of its rig. The drivers have a folder each:
//!
//! - [`simulated_rig`]: a rig that needs no hardware.
//! - [`moteus`]: a motor behind a moteus controller.
//! - [`plugin`]: a shared library with the C interface of `haptic_rig.h`.
//! - [`ethercat`]: CiA 402 servo drives on EtherCAT, with whatever else is on their bus.

mod apparatus;
mod channels;
pub mod ethercat;
pub mod moteus;
pub mod plugin;
mod rig_file;
mod scanned;
pub mod simulated_rig;
mod wired;

pub use apparatus::{Apparatus, ApparatusError, DeclaredCalls, Limits, Measurement, RigDescription, TorqueSource};
pub use channels::{Channel, ChannelError, Channels, MOST_CHANNELS, RawMeasurement, Scaling, TorqueChannel, Wiring};
pub use rig_file::{Rates, RigFile, RigFileError, Watchdog};
pub use scanned::Scanned;
