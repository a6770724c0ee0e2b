//! The rows of a map: torque and the columns that join one after the other, with their sums over stretches.

use nalgebra::{DMatrix, DVector};

use crate::regression::{Blocks, Gram, Solution, residual};
use crate::statistics::student_95;
use crate::vector::dot;

/// Stretches of equal length.
const BLOCKS: usize = 32;

/// Two-sided 95 % for a covariance from the scatter of the stretches.
pub(super) fn critical() -> f64 {
    student_95((BLOCKS - 1) as f64)
}

/// Target and columns.
pub(super) struct Rows {
    target: Vec<f64>,
    columns: Vec<Vec<f64>>,
    blocks: Blocks,
}

/// Coefficients with their covariances.
pub(super) struct Estimate {
    pub(super) coefficients: Vec<f64>,
    /// From the scatter of the stretches.
    pub(super) covariance: DMatrix<f64>,
    /// As textbooks have it.
    pub(super) textbook: DMatrix<f64>,
}

impl Rows {
    pub(super) fn new(columns: Vec<Vec<f64>>, target: Vec<f64>) -> Self {
        let blocks = Blocks::of(BLOCKS, &columns, &target);
        Self { target, columns, blocks }
    }

    pub(super) fn width(&self) -> usize {
        self.columns.len()
    }

    pub(super) fn extend(&mut self, columns: impl IntoIterator<Item = Vec<f64>>) {
        let width = self.width();
        self.columns.extend(columns);
        self.blocks.replace(width, &self.columns, &self.target);
    }

    pub(super) fn truncate(&mut self, width: usize) {
        self.columns.truncate(width);
        self.blocks.truncate(width);
    }

    /// Inner products over all rows.
    pub(super) fn total(&self) -> Gram {
        self.blocks.total()
    }

    /// Coefficients of all columns; `None` if these are sums of each other.
    pub(super) fn solve(&self) -> Option<Solution> {
        Some(self.total().solve()).filter(|solution| !solution.collinear.contains(&true))
    }

    /// Target minus columns times coefficients.
    pub(super) fn residual(&self, coefficients: &[f64]) -> Vec<f64> {
        residual(&self.columns, &self.target, coefficients)
    }

    /// By how many standard errors the columns from `base` on predict stretches that they were not fitted to.
    pub(super) fn evidence(&self, base: usize) -> f64 {
        self.blocks.evidence(base)
    }

    /// All columns' coefficients with covariances.
    pub(super) fn estimate(&self) -> Option<Estimate> {
        let solution = self.solve()?;
        let left = self.residual(&solution.coefficients);
        let variance = dot(&left, &left) / self.target.len().saturating_sub(self.width()).max(1) as f64;
        Some(Estimate {
            covariance: self.blocks.covariance(&solution, 1),
            textbook: solution.inverse * variance,
            coefficients: solution.coefficients,
        })
    }

    /// The columns' values in a row.
    pub(super) fn row(&self, index: usize) -> DVector<f64> {
        DVector::from_iterator(self.width(), self.columns.iter().map(|column| column[index]))
    }
}
