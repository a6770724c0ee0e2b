//! Numerical methods that know nothing of knobs: sums over columns, transforms, derivatives, interpolation and
//! statistics.

pub(crate) mod derivative;
pub(crate) mod fourier;
pub(crate) mod interpolation;
pub(crate) mod lag;
pub mod statistics;
pub(crate) mod vector;
