//! Least squares from sums over stretches of the capture: a further column costs little, and every stretch can be left out.

use nalgebra::{DMatrix, DVector};

use crate::regression::least_squares::dot;
use crate::uncertainty::statistics::student_95;

/// Stretches of equal length.
pub(super) const BLOCKS: usize = 32;

/// Products of columns and target, stretch by stretch.
pub(super) struct BlockSums {
    target: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Per stretch: products of a column with those up to itself.
    products: Vec<Vec<Vec<f64>>>,
    /// Per stretch: products of the columns with the target.
    cross: Vec<Vec<f64>>,
    /// Per stretch: square of the target.
    squares: Vec<f64>,
}

/// Coefficients with their covariances.
pub(super) struct Estimate {
    pub(super) coefficients: DVector<f64>,
    /// Allows for residuals that are correlated within a stretch and of varying size: the scatter of the stretches'
    /// own contributions (a sandwich over clusters; Liang and Zeger, Biometrika 73, 1986, 13–22).
    pub(super) covariance: DMatrix<f64>,
    /// As textbooks have it.
    pub(super) textbook: DMatrix<f64>,
}

/// Half width of a 95 % interval over the standard deviation: the stretches leave one degree of freedom less than their
/// number.
pub(super) fn critical() -> f64 {
    student_95((BLOCKS - 1) as f64)
}

impl BlockSums {
    pub(super) fn new(target: Vec<f64>) -> Self {
        let squares = (0..BLOCKS).map(|block| square(&target[range(block, target.len())])).collect();
        Self {
            target,
            columns: Vec::new(),
            products: vec![Vec::new(); BLOCKS],
            cross: vec![Vec::new(); BLOCKS],
            squares,
        }
    }

    pub(super) fn width(&self) -> usize {
        self.columns.len()
    }

    pub(super) fn push(&mut self, column: Vec<f64>) {
        self.columns.push(column);
        let Some(last) = self.columns.last() else { return };
        for block in 0..BLOCKS {
            let range = range(block, self.target.len());
            let part = &last[range.clone()];
            self.products[block].push(self.columns.iter().map(|other| dot(part, &other[range.clone()])).collect());
            self.cross[block].push(dot(part, &self.target[range.clone()]));
        }
    }

    pub(super) fn truncate(&mut self, width: usize) {
        self.columns.truncate(width);
        for block in 0..BLOCKS {
            self.products[block].truncate(width);
            self.cross[block].truncate(width);
        }
    }

    /// Coefficients of the chosen columns; `None` if they cannot be told apart.
    pub(super) fn solve(&self, chosen: &[usize]) -> Option<DVector<f64>> {
        self.solve_in(chosen, |_| true)
    }

    /// Sum of squares that the chosen columns leave.
    pub(super) fn left(&self, chosen: &[usize]) -> Option<f64> {
        let coefficients = self.solve(chosen)?;
        Some((0..BLOCKS).map(|block| self.left_in(block, chosen, &coefficients)).sum::<f64>().max(0.0))
    }

    /// Sum of squares of the target.
    pub(super) fn total(&self) -> f64 {
        self.squares.iter().sum()
    }

    /// Target minus columns times coefficients.
    pub(super) fn residual(&self, coefficients: &DVector<f64>) -> Vec<f64> {
        let mut residual = self.target.clone();
        for (column, coefficient) in self.columns.iter().zip(coefficients.iter()) {
            residual.iter_mut().zip(column).for_each(|(rest, value)| *rest -= coefficient * value);
        }
        residual
    }

    /// By how much the columns from `base` on lower the squared error of stretches that were left out of the fit (every
    /// other stretch, then the rest): mean of signed roots over its standard error, from the stretches' own scatter.
    #[allow(clippy::cast_precision_loss, reason = "a number of stretches")]
    pub(super) fn evidence(&self, base: usize) -> f64 {
        let all: Vec<usize> = (0..self.width()).collect();
        let mut gains = [0.0; BLOCKS];
        for parity in 0..2 {
            let kept = |block: usize| block % 2 == parity;
            let (Some(with), Some(without)) = (self.solve_in(&all, kept), self.solve_in(&all[..base], kept)) else {
                return 0.0;
            };
            for (block, slot) in gains.iter_mut().enumerate().filter(|(block, _)| !kept(*block)) {
                let gain = self.left_in(block, &all[..base], &without) - self.left_in(block, &all, &with);
                *slot = gain.abs().sqrt().copysign(gain);
            }
        }
        let count = BLOCKS as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count * (count - 1.0));
        mean / variance.sqrt().max(f64::MIN_POSITIVE)
    }

    /// All columns' coefficients with covariances.
    #[allow(clippy::cast_precision_loss, reason = "numbers of rows and stretches")]
    pub(super) fn estimate(&self) -> Option<Estimate> {
        let all: Vec<usize> = (0..self.width()).collect();
        let coefficients = self.solve(&all)?;
        let inverse = self.gram(&all, |_| true).cholesky()?.inverse();
        let mut spread = DMatrix::zeros(all.len(), all.len());
        for block in 0..BLOCKS {
            let score =
                self.cross_of(&all, |other| other == block) - self.gram(&all, |other| other == block) * &coefficients;
            spread += &score * score.transpose();
        }
        let (blocks, rows) = (BLOCKS as f64, self.target.len() as f64);
        let covariance = &inverse * spread * &inverse * (blocks / (blocks - 1.0));
        let variance = square(&self.residual(&coefficients)) / (rows - all.len() as f64).max(1.0);
        Some(Estimate { coefficients, covariance, textbook: inverse * variance })
    }

    /// The columns' values in a row.
    pub(super) fn row(&self, index: usize, row: &mut DVector<f64>) {
        row.iter_mut().zip(&self.columns).for_each(|(slot, column)| *slot = column[index]);
    }

    fn solve_in(&self, chosen: &[usize], kept: impl Fn(usize) -> bool + Copy) -> Option<DVector<f64>> {
        Some(self.gram(chosen, kept).cholesky()?.solve(&self.cross_of(chosen, kept)))
    }

    fn gram(&self, chosen: &[usize], kept: impl Fn(usize) -> bool) -> DMatrix<f64> {
        let mut gram = DMatrix::zeros(chosen.len(), chosen.len());
        for products in (0..BLOCKS).filter(|block| kept(*block)).map(|block| &self.products[block]) {
            for (row, a) in chosen.iter().enumerate() {
                for (column, b) in chosen.iter().enumerate() {
                    gram[(row, column)] += products[*a.max(b)][*a.min(b)];
                }
            }
        }
        gram
    }

    fn cross_of(&self, chosen: &[usize], kept: impl Fn(usize) -> bool) -> DVector<f64> {
        let sum = |column: &usize| (0..BLOCKS).filter(|block| kept(*block)).map(|b| self.cross[b][*column]).sum();
        DVector::from_iterator(chosen.len(), chosen.iter().map(sum))
    }

    fn left_in(&self, block: usize, chosen: &[usize], coefficients: &DVector<f64>) -> f64 {
        let cross = self.cross_of(chosen, |other| other == block);
        let gram = self.gram(chosen, |other| other == block);
        self.squares[block] - 2.0 * coefficients.dot(&cross) + coefficients.dot(&(gram * coefficients))
    }
}

fn range(block: usize, rows: usize) -> std::ops::Range<usize> {
    block * rows / BLOCKS..(block + 1) * rows / BLOCKS
}

fn square(values: &[f64]) -> f64 {
    dot(values, values)
}
