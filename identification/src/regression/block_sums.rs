//! Least squares from inner products over stretches of the capture: a further column costs little, and any stretch can be left out.

use nalgebra::DMatrix;

use super::gram::{self, COLLINEAR, Solution};
use super::least_squares::residual;
use crate::numerics::statistics::student_95;
use crate::numerics::vector::{dot, square};

/// Stretches of equal length.
pub(crate) const BLOCKS: usize = 32;

/// Target and columns with their inner products, stretch by stretch.
pub(crate) struct BlockSums {
    target: Vec<f64>,
    pub(crate) columns: Vec<Vec<f64>>,
    blocks: Vec<DMatrix<f64>>,
}

/// Coefficients with their covariances.
pub(crate) struct Estimate {
    pub(crate) coefficients: Vec<f64>,
    /// Allows for residuals that are correlated within a stretch and of varying size.
    pub(crate) covariance: DMatrix<f64>,
    /// The textbooks' covariance, for independent residuals of equal size.
    pub(crate) textbook: DMatrix<f64>,
}

/// Ratio of the half width of a 95 % interval to the standard deviation, for one degree of freedom less than there are
/// stretches.
pub(crate) fn critical() -> f64 {
    student_95((BLOCKS - 1) as f64)
}

impl BlockSums {
    pub(crate) fn new(target: Vec<f64>) -> Self {
        let square = |block| {
            let part = &target[range(block, target.len())];
            DMatrix::from_element(1, 1, square(part))
        };
        Self { blocks: (0..BLOCKS).map(square).collect(), target, columns: Vec::new() }
    }

    /// Number of columns.
    pub(crate) fn width(&self) -> usize {
        self.columns.len()
    }

    pub(crate) fn push(&mut self, column: Vec<f64>) {
        self.columns.push(column);
        let Some(last) = self.columns.last() else { return };
        let size = self.columns.len() + 1;
        for (block, products) in self.blocks.iter_mut().enumerate() {
            let range = range(block, self.target.len());
            let part = &last[range.clone()];
            products.resize_mut(size, size, 0.0);
            for (index, other) in [&self.target].into_iter().chain(&self.columns).enumerate() {
                let product = dot(part, &other[range.clone()]);
                (products[(size - 1, index)], products[(index, size - 1)]) = (product, product);
            }
        }
    }

    /// Drops all columns beyond the first `width`.
    pub(crate) fn truncate(&mut self, width: usize) {
        self.columns.truncate(width);
        self.blocks.iter_mut().for_each(|products| products.resize_mut(width + 1, width + 1, 0.0));
    }

    /// All columns' coefficients; `None` if they cannot be told apart.
    pub(crate) fn solve(&self) -> Option<Solution> {
        self.solve_for(&(0..self.width()).collect::<Vec<_>>())
    }

    /// Sum of squares that the chosen columns leave.
    pub(crate) fn squares_left(&self, chosen: &[usize]) -> Option<f64> {
        Some(self.solve_for(chosen)?.squares(&self.total()).max(0.0))
    }

    pub(crate) fn target_squares(&self) -> f64 {
        self.blocks.iter().map(|products| products[(0, 0)]).sum()
    }

    /// Target minus columns times coefficients.
    pub(crate) fn residual(&self, coefficients: &[f64]) -> Vec<f64> {
        residual(&self.columns, &self.target, coefficients)
    }

    /// [`gram::evidence`] for the columns from `base` on.
    pub(crate) fn evidence(&self, base: usize) -> f64 {
        gram::evidence(&self.blocks, base)
    }

    /// All columns' coefficients with covariances.
    pub(crate) fn estimate(&self) -> Option<Estimate> {
        let solution = self.solve()?;
        let left = self.residual(&solution.coefficients);
        let variance = square(&left) / (left.len() as f64 - self.width() as f64).max(1.0);
        Some(Estimate {
            covariance: solution.covariance_over(&self.blocks),
            textbook: solution.inverse() * variance,
            coefficients: solution.coefficients,
        })
    }

    fn total(&self) -> DMatrix<f64> {
        gram::sum(self.blocks.iter(), self.width() + 1)
    }

    fn solve_for(&self, chosen: &[usize]) -> Option<Solution> {
        gram::solve(&self.total(), chosen, COLLINEAR).filter(|solution| solution.fitted.len() == chosen.len())
    }
}

/// Rows of a stretch.
fn range(block: usize, rows: usize) -> std::ops::Range<usize> {
    block * rows / BLOCKS..(block + 1) * rows / BLOCKS
}
