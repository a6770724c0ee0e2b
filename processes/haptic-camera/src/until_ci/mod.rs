//! How well a capture must know a knob before it may end: `capture --until-ci`.
//!
//! A parameter is known well enough when half the width of its 95 % interval is at most the asked share of its value.
//! Three cases need a rule of their own:
//!
//! - A **phase** has no size of its own, since its zero is where the encoder's happens to be. An error of it is an error of
//!   the detent torque by as many radians times the amplitude, so the share is taken of one radian.
//! - A parameter **near zero** has no share worth the name. It is settled once even the far end of its interval makes less
//!   torque, over the motion so far, than one step of the torque sensor: nothing that this rig reads would show it.
//! - A parameter that the data **cannot tell yet** is waited for, since a later part of the sweep may excite it. One that the
//!   model does not have, detents on a knob without them, is not.

mod knowledge;
mod rule;
mod share;

pub use knowledge::{Knowledge, Known, Standing, Yardstick};
pub use rule::{Achieved, StopRule};
pub use share::Share;
