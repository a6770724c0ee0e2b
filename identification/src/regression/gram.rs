//! Least squares from inner products alone: those of blocks of rows add up, and any block can be left out.
//!
//! A matrix of products has the target in its first row and column, and the columns that are to explain it behind.

use std::ops::Deref;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use crate::numerics::statistics::mean_over_error;
use crate::numerics::vector;

/// A column of which less than this share of the square remains beside the others counts as collinear.
pub(crate) const COLLINEAR: f64 = 1e-9;
/// Noise of a column may make up at most this share of its square to be taken off: beyond, nothing would be left.
const MOST_NOISE: f64 = 0.5;
/// Least share of a variance that is taken for left: of less, nothing can be said.
const LEAST_LEFT: f64 = 0.1;
/// Stretches of a capture, alternately fitted and predicted.
const STRETCHES: usize = 16;

/// A term added to a column's inner products: a positive square holds the coefficient near a value (a ridge), a negative one takes off
/// the noise in the column.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction {
    pub(crate) column: usize,
    /// Added to the column's square.
    pub(crate) square: f64,
    /// Added to the column's product with the target.
    pub(crate) product: f64,
}

/// A least-squares problem: inner products of columns and a target, bounds and corrections.
pub(crate) struct Normal<'a> {
    /// Of the columns with each other.
    pub(crate) products: &'a DMatrix<f64>,
    /// Of the columns with the target.
    pub(crate) with_target: &'a [f64],
    /// The columns that may be fitted.
    pub(crate) chosen: &'a [usize],
    /// Which coefficients stay at or above zero.
    pub(crate) nonnegative: &'a [bool],
    pub(crate) corrections: &'a [Correction],
    /// Share of a column's square that must remain beside the earlier columns for it to be fitted.
    pub(crate) collinear: f64,
}

/// The solution of target ≈ Σ coefficient · column.
pub(crate) struct Solution {
    /// One per column; zero for those not fitted.
    pub(crate) coefficients: Vec<f64>,
    /// The columns that were fitted.
    pub(crate) fitted: Vec<usize>,
    /// Columns that are sums of earlier chosen ones, empty, or not chosen.
    pub(crate) collinear: Vec<bool>,
    corrections: Vec<Correction>,
    /// Lengths of the fitted columns.
    lengths: Vec<f64>,
    /// Of the Gram matrix of the fitted columns, each made one in length.
    factor: Cholesky<f64, Dyn>,
}

impl Normal<'_> {
    /// Solves for the columns that are not collinear. While coefficients that must not be negative are, the column of the most
    /// negative one is left out. `None` where the products are not finite or the corrections leave nothing.
    pub(crate) fn solve(&self) -> Option<Solution> {
        let count = self.with_target.len();
        let holds = self.corrections.iter().filter(|c| c.square > 0.0);
        let mut squares: Vec<f64> = self.products.diagonal().iter().copied().collect();
        holds.for_each(|c| squares[c.column] += c.square);
        let lengths: Vec<f64> = squares.iter().map(|square| square.sqrt()).collect();
        let mut gram = self.products.clone();
        (0..count).for_each(|column| gram[(column, column)] = squares[column]);
        gram = gram.map_with_location(|row, column, product| product / (lengths[row] * lengths[column]));
        let collinear = find_collinear(&gram, self.chosen, self.collinear);
        let leaves_enough = |c: &&Correction| c.square > -MOST_NOISE * squares[c.column];
        let corrections: Vec<Correction> = self.corrections.iter().filter(leaves_enough).copied().collect();
        let noise = corrections.iter().filter(|c| c.square < 0.0);
        noise.for_each(|c| gram[(c.column, c.column)] += c.square / squares[c.column]);
        let mut solution = Solution {
            coefficients: vec![0.0; count],
            fitted: self.chosen.iter().copied().filter(|column| !collinear[*column]).collect(),
            collinear,
            corrections,
            lengths: Vec::new(),
            factor: Cholesky::new(DMatrix::identity(0, 0))?,
        };
        loop {
            let fitted = &solution.fitted;
            solution.factor = Cholesky::new(gram.select_rows(fitted).select_columns(fitted))?;
            solution.lengths = fitted.iter().map(|column| lengths[*column]).collect();
            let step = solution.step(self.with_target);
            let negative = solution.fitted.iter().zip(step.iter()).enumerate();
            let negative = negative.filter(|(_, (column, value))| self.nonnegative[**column] && **value < 0.0);
            match negative.min_by(|(_, (_, one)), (_, (_, other))| one.total_cmp(other)).map(|(place, _)| place) {
                Some(place) => drop(solution.fitted.remove(place)),
                None => {
                    solution.take(&step);
                    return Some(solution);
                }
            }
        }
    }
}

/// Solves for the `chosen` columns of a matrix of products that has the target first.
pub(crate) fn solve(products: &DMatrix<f64>, chosen: &[usize], collinear: f64) -> Option<Solution> {
    let columns = 1..products.nrows();
    let with_target: Vec<f64> = columns.clone().map(|column| products[(column, 0)]).collect();
    let solution = Normal {
        products: &products.view_range(columns.clone(), columns).into_owned(),
        with_target: &with_target,
        chosen,
        nonnegative: &vec![false; with_target.len()],
        corrections: &[],
        collinear,
    };
    solution.solve()
}

impl Solution {
    /// Improves the coefficients by the step that follows from the columns' inner products with the residual. Returns `true`, without
    /// taking the step, if it would move the prediction by no more than `settled`.
    pub(crate) fn improve(&mut self, with_residual: &[f64], settled: f64) -> bool {
        let step = self.step(with_residual);
        let is_settled = step.norm() <= settled;
        if !is_settled {
            self.take(&step);
        }
        is_settled
    }

    /// Step of the coefficients, counted in lengths of the columns.
    fn step(&self, products: &[f64]) -> DVector<f64> {
        let right = self.fitted.iter().zip(&self.lengths).map(|(column, length)| {
            let of_column = self.corrections.iter().filter(|c| c.column == *column);
            let correction: f64 = of_column.map(|c| c.product - c.square * self.coefficients[*column]).sum();
            (products[*column] + correction) / length
        });
        self.factor.solve(&DVector::from_iterator(self.fitted.len(), right))
    }

    fn take(&mut self, step: &DVector<f64>) {
        for ((column, length), step) in self.fitted.iter().zip(&self.lengths).zip(step.iter()) {
            self.coefficients[*column] += step / length;
        }
    }

    /// Inverse of the fitted columns' Gram matrix; rows and columns of columns that were not fitted are zero.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        let whitening = self.whitening();
        whitening.tr_mul(&whitening)
    }

    /// The coefficients of as many combinations of the columns as were fitted, row by row, that are orthonormal over all rows.
    fn whitening(&self) -> DMatrix<f64> {
        let mut whitening = DMatrix::from_fn(self.fitted.len(), self.coefficients.len(), |row, column| {
            if column == self.fitted[row] { 1.0 / self.lengths[row] } else { 0.0 }
        });
        self.factor.l().solve_lower_triangular_mut(&mut whitening);
        whitening
    }

    /// Sum of squares that it leaves of rows with these products.
    pub(crate) fn squares(&self, products: &DMatrix<f64>) -> f64 {
        squares_left(products, &self.coefficients)
    }

    /// Covariance of the coefficients for residuals that are correlated within a block and of varying size: the scatter of
    /// the blocks' own contributions (a sandwich over clusters; Liang and Zeger, Biometrika 73, 1986, 13–22), restored from what the
    /// fit has taken off it.
    ///
    /// Of G blocks that see the columns alike, the fit of any number of columns takes off the share 1/G. Of blocks so short that each
    /// sees one combination of k columns it takes off k/G. The blocks' own products say what lies between.
    pub(crate) fn covariance_over(&self, blocks: &[DMatrix<f64>]) -> DMatrix<f64> {
        let count = self.fitted.len();
        let (weights, whitening) = (weights(&self.coefficients), self.whitening());
        let [mut scatter, mut lost] = [(); 2].map(|()| DMatrix::<f64>::zeros(count, count));
        for products in blocks {
            let score = &whitening * (products * &weights).remove_row(0);
            scatter += &score * score.transpose();
            let share = &whitening * products.view_range(1.., 1..) * whitening.transpose();
            lost += &share * &share;
        }
        let back = whitening.tr_mul(&restoring(lost));
        &back * scatter * back.transpose()
    }
}

/// (1 − Q)^(−1/2) for the share Q of the scores' covariance that a fit has taken: on both sides of what is left, it restores the whole
/// (R. M. Bell and D. F. McCaffrey, Survey Methodology 28, 2002, 169–181).
pub(crate) fn restoring(taken: DMatrix<f64>) -> DMatrix<f64> {
    if taken.is_empty() {
        return taken;
    }
    let left = (DMatrix::identity(taken.nrows(), taken.ncols()) - taken).symmetric_eigen();
    let powers = DMatrix::from_diagonal(&left.eigenvalues.map(|share| share.max(LEAST_LEFT).powf(-0.5)));
    &left.eigenvectors * powers * left.eigenvectors.transpose()
}

/// Sum of squares that coefficients leave of rows with these products, those of the target first.
pub(crate) fn squares_left(products: &DMatrix<f64>, coefficients: &[f64]) -> f64 {
    let weights = weights(coefficients);
    weights.dot(&(products * &weights))
}

/// Weights with which target and columns add up to minus the residual.
fn weights(coefficients: &[f64]) -> DVector<f64> {
    DVector::from_iterator(coefficients.len() + 1, std::iter::once(-1.0).chain(coefficients.iter().copied()))
}

/// How much the columns beyond the first `base` lower the squared error of blocks that were left out of the fit: the mean of the
/// blocks' signed roots in standard errors of that mean, from the blocks' own scatter; zero where nothing can be fitted.
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

/// [`evidence`] for the columns beyond the first `base`, over stretches of the capture.
pub(crate) fn held_out_evidence<C: Deref<Target = [f64]>>(columns: &[C], base: usize, target: &[f64]) -> f64 {
    let length = target.len().div_ceil(STRETCHES).max(1);
    let blocks: Vec<DMatrix<f64>> = (0..STRETCHES)
        .map(|stretch| {
            let rows = (stretch * length).min(target.len())..((stretch + 1) * length).min(target.len());
            let all = std::iter::once(target).chain(columns.iter().map(|column| &**column));
            vector::gram(&all.map(|column| &column[rows.clone()]).collect::<Vec<_>>())
        })
        .collect();
    evidence(&blocks, base)
}

/// Sum of products of `size` rows and columns.
pub(crate) fn sum<'a>(blocks: impl Iterator<Item = &'a DMatrix<f64>>, size: usize) -> DMatrix<f64> {
    blocks.fold(DMatrix::zeros(size, size), |sum, products| sum + products)
}

/// Marks the columns to leave out: those not chosen, empty ones, and those of whose squares no more than the share `collinear`
/// remains beside earlier ones. The pivots of Cholesky's factorisation give this share for each column.
fn find_collinear(gram: &DMatrix<f64>, chosen: &[usize], collinear: f64) -> Vec<bool> {
    let count = gram.nrows();
    let mut found = vec![true; count];
    let mut factor = DMatrix::<f64>::zeros(count, count);
    for row in chosen.iter().copied() {
        for column in (0..row).filter(|column| !found[*column]) {
            let sum: f64 = (0..column).map(|k| factor[(row, k)] * factor[(column, k)]).sum();
            factor[(row, column)] = (gram[(row, column)] - sum) / factor[(column, column)];
        }
        let left = gram[(row, row)] - (0..row).map(|k| factor[(row, k)].powi(2)).sum::<f64>();
        // An empty column has length zero, so `left` is not a number and the column stays out.
        if left > collinear {
            factor[(row, row)] = left.sqrt();
            found[row] = false;
        } else {
            (0..row).for_each(|k| factor[(row, k)] = 0.0);
        }
    }
    found
}
