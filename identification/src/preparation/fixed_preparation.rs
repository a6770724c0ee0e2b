//! Motion, torque and rows of a preparation whose filters do not depend on the data.

use super::frame::Frame;
use super::motion::{Band, KnobMotion};

/// What a preparation hands to the fit.
pub(crate) struct FixedPreparation {
    pub(crate) motion: KnobMotion,
    pub(crate) torque_mnm: Vec<f64>,
    pub(crate) frame: Frame,
    pub(crate) band: Band,
}
