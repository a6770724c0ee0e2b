//! Least squares from inner products alone: those of blocks of rows add up, and any block can be left out.
//!
//! A matrix of products has the target in its first row and column, and the columns that are to explain it behind.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::uncertainty::statistics::mean_over_error;

/// A column of which less than this share of the square remains beside the others counts as collinear.
pub(crate) const COLLINEAR: f64 = 1e-9;

/// The solution of target ≈ Σ coefficient · column.
pub(crate) struct Solution {
    /// One per column; zero for those not chosen, empty, or sums of earlier ones.
    pub(crate) coefficients: DVector<f64>,
    /// The columns that were fitted.
    pub(crate) fitted: Vec<usize>,
    /// Their lengths.
    scales: Vec<f64>,
    /// Of the Gram matrix of the fitted columns, each made one in length.
    factor: Cholesky<f64, Dyn>,
}

/// Solves for the `chosen` columns without those of which less than the share `collinear` remains beside the earlier ones.
/// `None` where the products are not finite.
pub(crate) fn solve(products: &DMatrix<f64>, chosen: &[usize], collinear: f64) -> Option<Solution> {
    let scales: Vec<f64> = chosen.iter().map(|column| products[(column + 1, column + 1)].sqrt()).collect();
    let gram = DMatrix::from_fn(chosen.len(), chosen.len(), |row, column| {
        products[(chosen[row] + 1, chosen[column] + 1)] / (scales[row] * scales[column])
    });
    let is_collinear = find_collinear(&gram, &scales, collinear);
    let active: Vec<usize> = (0..chosen.len()).filter(|index| !is_collinear[*index]).collect();
    let factor = Cholesky::new(gram.select_rows(&active).select_columns(&active))?;
    let fitted: Vec<usize> = active.iter().map(|index| chosen[*index]).collect();
    let scales: Vec<f64> = active.iter().map(|index| scales[*index]).collect();
    let right = fitted.iter().zip(&scales).map(|(column, scale)| products[(column + 1, 0)] / scale);
    let solved = factor.solve(&DVector::from_iterator(fitted.len(), right));
    let mut coefficients = DVector::zeros(products.nrows() - 1);
    for ((column, scale), value) in fitted.iter().zip(&scales).zip(solved.iter()) {
        coefficients[*column] = value / scale;
    }
    Some(Solution { coefficients, fitted, scales, factor })
}

impl Solution {
    /// Inverse of the fitted columns' Gram matrix, zero in the rows and columns of the others.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        unscaled_inverse(&self.factor, &self.fitted, &self.scales, self.coefficients.len())
    }

    /// Sum of squares that it leaves of rows with these products.
    pub(crate) fn squares(&self, products: &DMatrix<f64>) -> f64 {
        let weights = self.weights();
        weights.dot(&(products * &weights))
    }

    /// Covariance of the coefficients for residuals that are correlated within a block and of varying size: the scatter of
    /// the blocks' own contributions (a sandwich over clusters; Liang and Zeger, Biometrika 73, 1986, 13–22).
    pub(crate) fn covariance_over(&self, blocks: &[DMatrix<f64>]) -> DMatrix<f64> {
        let count = self.coefficients.len();
        let weights = self.weights();
        let mut scatter = DMatrix::zeros(count, count);
        for products in blocks {
            let score = (products * &weights).remove_row(0);
            scatter += &score * score.transpose();
        }
        let inverse = self.inverse();
        &inverse * scatter * &inverse
    }

    /// What target and columns count in the residual, with the sign turned.
    fn weights(&self) -> DVector<f64> {
        self.coefficients.clone().insert_row(0, -1.0)
    }
}

/// By how much the columns beyond the first `base` lower the squared error of blocks that were left out of the fit: mean over
/// the blocks (of signed roots) in standard errors of that mean, from the blocks' own scatter; zero where nothing can be fitted.
///
/// Every other block is predicted from the rest, then the other way round, with and without the further columns.
pub(crate) fn evidence(blocks: &[DMatrix<f64>], base: usize) -> f64 {
    let Some(size) = blocks.first().map(DMatrix::nrows) else { return 0.0 };
    let all: Vec<usize> = (0..size - 1).collect();
    let mut gains = vec![0.0; blocks.len()];
    for parity in 0..2 {
        let fitted = sum(blocks.iter().skip(parity).step_by(2), size);
        let [with, without] = [&all[..], &all[..base]].map(|chosen| solve(&fitted, chosen, COLLINEAR));
        let (Some(with), Some(without)) = (with, without) else { return 0.0 };
        for block in (1 - parity..blocks.len()).step_by(2) {
            let gain: f64 = without.squares(&blocks[block]) - with.squares(&blocks[block]);
            // Signed roots: one block where the rest of the model fails must not drown what the others say.
            gains[block] = gain.abs().sqrt().copysign(gain);
        }
    }
    mean_over_error(&gains)
}

/// Sum of products of `size` rows and columns.
pub(crate) fn sum<'a>(blocks: impl Iterator<Item = &'a DMatrix<f64>>, size: usize) -> DMatrix<f64> {
    blocks.fold(DMatrix::zeros(size, size), |sum, products| sum + products)
}

/// The inverse of a scaled Gram matrix of the columns at `places` as that of all `count` columns, zero for the others.
pub(crate) fn unscaled_inverse(
    factor: &Cholesky<f64, Dyn>,
    places: &[usize],
    scales: &[f64],
    count: usize,
) -> DMatrix<f64> {
    let inverse = factor.inverse();
    let mut all = DMatrix::zeros(count, count);
    for (row, at) in places.iter().enumerate() {
        for (column, other) in places.iter().enumerate() {
            all[(*at, *other)] = inverse[(row, column)] / (scales[row] * scales[column]);
        }
    }
    all
}

/// Which column must go next for the coefficients marked in `nonnegative` to stay at or above zero: the place among the
/// `active` ones of that with the most negative coefficient, coefficients being counted in columns of one length.
pub(crate) fn most_negative(
    active: &[usize],
    scaled: impl Iterator<Item = f64>,
    nonnegative: &[bool],
) -> Option<usize> {
    let negative = scaled.enumerate().filter(|(place, value)| nonnegative[active[*place]] && *value < 0.0);
    negative.min_by(|one, other| one.1.total_cmp(&other.1)).map(|(place, _)| place)
}

/// Which columns are empty or, but for the share `collinear` of their squares, sums of earlier ones: Cholesky's pivots tell how
/// much of each is new.
pub(crate) fn find_collinear(gram: &DMatrix<f64>, scales: &[f64], collinear: f64) -> Vec<bool> {
    let count = scales.len();
    let mut found: Vec<bool> = scales.iter().map(|scale| !(*scale > 0.0 && scale.is_finite())).collect();
    let mut factor = DMatrix::<f64>::zeros(count, count);
    for row in 0..count {
        if found[row] {
            continue;
        }
        for column in (0..row).filter(|column| !found[*column]).collect::<Vec<_>>() {
            let sum: f64 = (0..column).map(|k| factor[(row, k)] * factor[(column, k)]).sum();
            factor[(row, column)] = (gram[(row, column)] - sum) / factor[(column, column)];
        }
        let left = gram[(row, row)] - (0..row).map(|k| factor[(row, k)].powi(2)).sum::<f64>();
        if left > collinear {
            factor[(row, row)] = left.sqrt();
        } else {
            found[row] = true;
            (0..row).for_each(|k| factor[(row, k)] = 0.0);
        }
    }
    found
}
