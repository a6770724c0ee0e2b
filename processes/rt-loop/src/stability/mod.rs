//! What can be rendered on a rig without shaking: computed from its calibration, rate and gains.

mod bounds;
mod port;

pub use bounds::{BoundExceeded, Bounds};
pub use port::{Hands, LinearModel, Port};
