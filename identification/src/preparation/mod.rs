//! From a capture's columns to rows of a regression: one sample rate, the knob's motion, the band in which it is signal, and the mask that
//! leaves out standstill, gaps and saturation.

pub(crate) mod angle_spectrum;
pub(crate) mod central_differences;
pub(crate) mod compliance;
pub(crate) mod encoder_step;
pub mod filter;
pub(crate) mod fixed_preparation;
mod fusion;
pub(crate) mod knob_motion;
pub(crate) mod motion;
pub(crate) mod paper_preparation;
pub(crate) mod row_filter;
pub(crate) mod sampling;
pub(crate) mod saturation;
pub(crate) mod sensor_noise;
pub(crate) mod spectrum;
pub(crate) mod time_order;
pub(crate) mod uniform;
