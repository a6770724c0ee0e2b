//! What can be rendered on a rig without shaking: computed from its calibration, rate and gains.

mod bounds;
mod contact;
mod port;
mod softened;

pub(crate) use bounds::FASTEST_RAD_S;
pub use bounds::{BoundExceeded, Bounded, Bounds, driving_speed_rad_s};
pub(crate) use port::{ACTUATOR_DELAY_S, SENSOR_DAMPING_RATIO};
pub use port::{Hands, InnerPart, LinearModel, Port};
pub use softened::{Firmness, gains_for};
