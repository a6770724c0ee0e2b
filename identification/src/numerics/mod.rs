//! Numerical methods that know nothing of knobs: sums over columns, transforms, derivatives and interpolation.

pub(crate) mod derivative;
pub(crate) mod fourier;
pub(crate) mod interpolation;
pub(crate) mod lag;
pub(crate) mod vector;
