//! Whether columns predict what they were not fitted to.

use nalgebra::{DMatrix, DVector};

use super::least_squares::solve_products;
use super::problem::Column;
use crate::numerics::vector;

/// Stretches of the capture, alternately fitted and predicted.
const BLOCKS: usize = 16;

/// By how much the columns beyond the first `base` lower the squared error of stretches that were left out of the
/// fit: mean over stretches (of signed roots) in standard errors of that mean, from the stretches' own scatter.
///
/// Every other stretch is predicted from the rest, then the other way round, with and without the further columns.
/// A stretch takes part by its inner products alone.
#[allow(clippy::cast_precision_loss, reason = "a number of stretches")]
pub(crate) fn evidence(columns: &[Column], base: usize, target: &Column) -> f64 {
    let count = columns.len();
    let length = target.len().div_ceil(BLOCKS).max(1);
    let blocks: Vec<DMatrix<f64>> = (0..BLOCKS)
        .map(|block| {
            let rows = (block * length).min(target.len())..((block + 1) * length).min(target.len());
            let part: Vec<&[f64]> = columns.iter().chain([target]).map(|column| &column[rows.clone()]).collect();
            let mut products = DMatrix::zeros(count + 1, count + 1);
            vector::products(&part, 0, &mut products);
            products
        })
        .collect();
    let mut gains = [0.0; BLOCKS];
    for parity in 0..2 {
        let mut fitted = DMatrix::zeros(count + 1, count + 1);
        blocks.iter().skip(parity).step_by(2).for_each(|block| fitted += block);
        let with = solve(&fitted, count);
        let without = solve(&fitted, base);
        for block in (1 - parity..BLOCKS).step_by(2) {
            gains[block] = error(&blocks[block], &without) - error(&blocks[block], &with);
        }
    }
    // Signed roots: one stretch where the rest of the model fails must not drown what the others say.
    let gains = gains.map(|gain: f64| gain.abs().sqrt().copysign(gain));
    let count = BLOCKS as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count * (count - 1.0));
    mean / variance.sqrt().max(f64::MIN_POSITIVE)
}

/// Coefficients of the first `count` columns for the target, whose products come last, and −1 for the target itself.
fn solve(products: &DMatrix<f64>, count: usize) -> DVector<f64> {
    let last = products.nrows() - 1;
    let mut coefficients = DVector::zeros(last + 1);
    coefficients[last] = -1.0;
    for (index, value) in solve_products(products, count).into_iter().enumerate() {
        coefficients[index] = value;
    }
    coefficients
}

/// Squared error of a stretch.
fn error(products: &DMatrix<f64>, coefficients: &DVector<f64>) -> f64 {
    coefficients.dot(&(products * coefficients))
}
