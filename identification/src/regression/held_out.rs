//! Whether columns predict what they were not fitted to.

use nalgebra::DMatrix;

use super::gram;
use super::problem::Column;
use crate::numerics::vector;

/// Stretches of the capture, alternately fitted and predicted.
const BLOCKS: usize = 16;

/// [`gram::evidence`] for the columns beyond the first `base`, over stretches of the capture.
pub(crate) fn evidence(columns: &[Column], base: usize, target: &Column) -> f64 {
    let length = target.len().div_ceil(BLOCKS).max(1);
    let blocks: Vec<DMatrix<f64>> = (0..BLOCKS)
        .map(|block| {
            let rows = (block * length).min(target.len())..((block + 1) * length).min(target.len());
            let part: Vec<&[f64]> = [target].into_iter().chain(columns).map(|column| &column[rows.clone()]).collect();
            vector::gram(&part)
        })
        .collect();
    gram::evidence(&blocks, base)
}
