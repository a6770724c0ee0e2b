//! From a capture's columns to rows of a regression: one sample rate, the knob's motion, the band in which it is signal, and the mask that
//! leaves out standstill, gaps and saturation.

pub(crate) mod band;
pub(crate) mod clock;
pub(crate) mod compliance;
pub(crate) mod encoder_step;
pub mod filter;
pub(crate) mod fixed_preparation;
mod fusion;
pub(crate) mod motion;
pub(crate) mod outliers;
mod repeated_rows;
pub(crate) mod row_filter;
pub(crate) mod sampling;
pub(crate) mod saturation;
pub(crate) mod sensor_noise;
pub(crate) mod spectrum;
pub(crate) mod uniform;
pub(crate) mod wrapped;

use std::borrow::Cow;

/// Motion, torque, mask and filter for one band.
pub(crate) struct Prepared<'a> {
    pub(crate) band: band::Band,
    pub(crate) motion: motion::KnobMotion,
    pub(crate) torque_mnm: Cow<'a, [f64]>,
    pub(crate) row_filter: row_filter::RowFilter,
}
