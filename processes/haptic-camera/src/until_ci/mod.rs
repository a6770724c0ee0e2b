//! How well a capture must know a knob before it may end: `capture --until-ci`.
//!
//! Whether a parameter is known well enough is the live fit's word ([`identification::live::Criterion`]). One that the data
//! cannot tell yet is waited for, since a later part of the sweep may excite it. One that the model does not have, detents on
//! a knob without them, is not.

mod knowledge;
mod rule;
mod share;

pub use knowledge::{Knowledge, Known};
pub use rule::{Achieved, StopRule};
pub use share::Share;
