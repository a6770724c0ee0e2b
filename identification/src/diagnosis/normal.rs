//! Normal equations that grow column by column.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::least_squares::dot;

/// A column of which less than this share of the square remains beside the others counts as collinear.
const COLLINEAR: f64 = 1e-8;

/// Solves target ≈ Σ coefficient · column; coefficients marked stay at or above zero, collinear columns get zero.
///
/// The products of the columns are formed once, whatever coefficients are at their bound.
pub(crate) fn solve(columns: &[&[f64]], target: &[f64], nonnegative: &[bool]) -> Vec<f64> {
    let count = columns.len();
    let scales: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt().max(f64::MIN_POSITIVE)).collect();
    let mut gram = DMatrix::zeros(count, count);
    for row in 0..count {
        for column in 0..=row {
            let product = dot(columns[row], columns[column]) / (scales[row] * scales[column]);
            (gram[(row, column)], gram[(column, row)]) = (product, product);
        }
    }
    let right: Vec<f64> = columns.iter().zip(&scales).map(|(column, scale)| dot(column, target) / scale).collect();
    // Where columns are sums of each other, one that may have either sign is kept: it can do what the others may not.
    let mut order: Vec<usize> = (0..count).filter(|index| !nonnegative[*index]).collect();
    order.extend((0..count).filter(|index| nonnegative[*index]));
    let ordered = DMatrix::from_fn(count, count, |row, column| gram[(order[row], order[column])]);
    let kept = independent(&ordered);
    let mut free: Vec<usize> = order.iter().zip(kept).filter(|(_, kept)| *kept).map(|(index, _)| *index).collect();
    loop {
        let part = DMatrix::from_fn(free.len(), free.len(), |row, column| gram[(free[row], free[column])]);
        let side = DVector::from_iterator(free.len(), free.iter().map(|index| right[*index]));
        let Some(solved) = Cholesky::new(part).map(|factor| factor.solve(&side)) else {
            return vec![0.0; count];
        };
        let worst = free
            .iter()
            .zip(solved.iter())
            .enumerate()
            .filter(|(_, (index, value))| nonnegative[**index] && **value < 0.0)
            .min_by(|(_, (_, a)), (_, (_, b))| a.total_cmp(b));
        if let Some((place, _)) = worst {
            free.remove(place);
            continue;
        }
        let mut coefficients = vec![0.0; count];
        for (index, value) in free.iter().zip(solved.iter()) {
            coefficients[*index] = value / scales[*index];
        }
        return coefficients;
    }
}

/// Target minus Σ coefficient · column.
pub(crate) fn residual(columns: &[&[f64]], target: &[f64], coefficients: &[f64]) -> Vec<f64> {
    let mut left = target.to_vec();
    for (column, coefficient) in columns.iter().zip(coefficients).filter(|(_, coefficient)| **coefficient != 0.0) {
        left.iter_mut().zip(*column).for_each(|(slot, value)| *slot -= coefficient * value);
    }
    left
}

/// Which columns are not sums of earlier ones, by a Cholesky factorisation that leaves these out.
fn independent(gram: &DMatrix<f64>) -> Vec<bool> {
    let count = gram.nrows();
    let mut factor: DMatrix<f64> = DMatrix::zeros(count, count);
    let mut independent = vec![true; count];
    for row in 0..count {
        let mut left = gram[(row, row)];
        for column in 0..row {
            if !independent[column] {
                continue;
            }
            let known: f64 = (0..column).map(|k| factor[(row, k)] * factor[(column, k)]).sum();
            factor[(row, column)] = (gram[(row, column)] - known) / factor[(column, column)];
            left -= factor[(row, column)].powi(2);
        }
        independent[row] = left > COLLINEAR;
        factor[(row, row)] = left.max(0.0).sqrt();
    }
    independent
}
