//! Motion, torque and rows of a preparation whose filters do not depend on the data.

use super::motion::{Band, KnobMotion};
use super::row_filter::RowFilter;

/// What a preparation hands to the fit.
pub(crate) struct FixedPreparation {
    pub(crate) motion: KnobMotion,
    pub(crate) torque_mnm: Vec<f64>,
    pub(crate) row_filter: RowFilter,
    pub(crate) band: Band,
}
