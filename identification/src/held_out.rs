//! Whether columns predict what they were not fitted to.

use crate::least_squares::{LeastSquares, dot};

/// Stretches of the capture, alternately fitted and predicted.
const BLOCKS: usize = 16;

/// By how much the columns beyond the first `base` lower the squared error of stretches that were left out of the
/// fit: mean over stretches (of signed roots) in standard errors of that mean, from the stretches' own scatter.
///
/// Every other stretch is predicted from the rest, then the other way round, with and without the further columns.
#[allow(clippy::cast_precision_loss, reason = "a number of stretches")]
pub(crate) fn evidence(columns: &[Vec<f64>], base: usize, target: &[f64]) -> f64 {
    let length = target.len().div_ceil(BLOCKS).max(1);
    let block = |row: usize| row / length;
    let mut gains = [0.0; BLOCKS];
    for parity in 0..2 {
        let kept = |values: &[f64]| -> Vec<f64> {
            let rows = values.iter().enumerate();
            rows.map(|(row, value)| if block(row) % 2 == parity { *value } else { 0.0 }).collect()
        };
        let fitted: Vec<Vec<f64>> = columns.iter().map(|column| kept(column)).collect();
        let target_kept = kept(target);
        let free = vec![false; columns.len()];
        let with = LeastSquares::solve(&fitted, &target_kept, &free).coefficients;
        let mut without = LeastSquares::solve(&fitted[..base], &target_kept, &free[..base]).coefficients;
        without.resize(columns.len(), 0.0);
        let mut row = vec![0.0; columns.len()];
        for (index, torque) in target.iter().enumerate().filter(|(index, _)| block(*index) % 2 != parity) {
            row.iter_mut().zip(columns).for_each(|(slot, column)| *slot = column[index]);
            gains[block(index)] += (torque - dot(&row, &without)).powi(2) - (torque - dot(&row, &with)).powi(2);
        }
    }
    // Signed roots: one stretch where the rest of the model fails must not drown what the others say.
    let gains = gains.map(|gain: f64| gain.abs().sqrt().copysign(gain));
    let count = BLOCKS as f64;
    let mean = gains.iter().sum::<f64>() / count;
    let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count * (count - 1.0));
    mean / variance.sqrt().max(f64::MIN_POSITIVE)
}
