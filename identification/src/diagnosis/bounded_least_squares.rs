//! Least squares of columns that may be sums of each other, some of them with coefficients that cannot be negative.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::numerics::vector::dot;
use crate::regression::gram::most_negative;

/// What holds a coefficient of either sign near zero, as a share of its column's square: too little to be felt unless
/// other columns can do the same.
const HELD: f64 = 1e-8;
/// The same for coefficients that cannot be negative.
const FIRM: f64 = 1e-11;

/// Solves target ≈ Σ coefficient · column; coefficients marked stay at or above zero, empty columns get zero.
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
    // Where columns are sums of each other, as an offset is of two levels of friction, the one that may have either
    // sign is held small: it takes over only what the others, at their bounds, cannot do.
    for (index, nonnegative) in nonnegative.iter().enumerate() {
        gram[(index, index)] += if *nonnegative { FIRM } else { HELD };
    }
    let mut free: Vec<usize> = (0..count).filter(|index| gram[(*index, *index)] > 0.5).collect();
    loop {
        let side = DVector::from_iterator(free.len(), free.iter().map(|index| right[*index]));
        let Some(solved) =
            Cholesky::new(gram.select_rows(&free).select_columns(&free)).map(|factor| factor.solve(&side))
        else {
            return vec![0.0; count];
        };
        if let Some(place) = most_negative(&free, solved.iter().copied(), nonnegative) {
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
