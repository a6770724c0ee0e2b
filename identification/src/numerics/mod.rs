//! What every other folder counts with: sums over columns and transforms.

pub(crate) mod fourier;
pub(crate) mod vector;
