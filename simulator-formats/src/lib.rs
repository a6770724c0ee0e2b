//! Models in the formats of other simulators, in SI units, and of firmware, and what those cannot say, as a number.
//!
//! A format says some effects exactly and lacks others. What it says is again a [`dynamics::Model`], [`Export::said`], so that what
//! is left out can be put as torque along any motion: [`left_out_mnm`].
//!
//! | format | function | says |
//! |---|---|---|
//! | MuJoCo's MJCF | [`mjcf()`] | inertia, friction, sinusoidal torques of the angle, springs, drag, bristles, backlash, a soft shaft |
//! | URDF | [`urdf()`] | inertia, friction that is the same in both directions, end stops |
//! | Isaac Lab's actuators | [`isaac_lab`] | the same, and what breaks the joint away |
//! | FMI 3.0 | [`fmi::fmu`] | all that is the knob's |
//! | a table over the angle | [`TorqueOverAngle`] | all torques that repeat with the detents, or in a turn |
//! | a C header | [`c_header`] | every parameter, and that table |
//! | SmartKnob's configuration | [`smartknob()`] | detents as springs, end stops |
//!
//! Models of what is pressed or slid have the table and the header; the other formats refuse them with [`LinearAxis`].
//!
//! [`into_mjcf`] goes the other way: it writes what was identified into a joint of somebody's own MJCF.

mod firmware;
pub mod fmi;
mod into_mjcf;
mod isaac;
mod joint;
mod mjcf;
mod said;
mod smartknob;
mod torque_over_angle;
mod urdf;
mod xml;

pub use firmware::c_header;
pub use into_mjcf::{IntoMjcfError, into_mjcf};
pub use isaac::isaac_lab;
pub use mjcf::mjcf;
pub use said::{Export, LinearAxis, left_out_by_mnm, left_out_mnm};
pub use smartknob::{ALL as SMARTKNOBS, SmartKnob, SmartKnobExport, smartknob};
pub use torque_over_angle::{TableSpan, TabulationError, TorqueOverAngle};
pub use urdf::urdf;
