//! What can be rendered on a rig without shaking: computed from its calibration, rate and gains.

mod bounds;
mod port;

pub use bounds::{BoundExceeded, Bounds, driving_speed_rad_s};
pub use port::{Hands, LinearModel, Port};
