//! Sums over stretches of the rows, each of which can be left out: what columns predict, and how surely.

use std::ops::{Deref, Range};

use nalgebra::DMatrix;

use super::gram::{Gram, Solution};
use crate::statistics::mean_in_errors;

/// Inner products of consecutive stretches of rows.
#[derive(Clone, Debug)]
pub(crate) struct Blocks(pub(crate) Vec<Gram>);

impl Blocks {
    /// So many stretches of equal length.
    pub(crate) fn of<C: Deref<Target = [f64]>>(count: usize, columns: &[C], target: &[f64]) -> Self {
        let mut blocks = Self(vec![Gram::empty(0); count]);
        blocks.replace(0, columns, target);
        blocks
    }

    /// Forms the products of the columns from `first` on anew.
    pub(crate) fn replace<C: Deref<Target = [f64]>>(&mut self, first: usize, columns: &[C], target: &[f64]) {
        let count = self.0.len();
        for (block, gram) in self.0.iter_mut().enumerate() {
            let rows = rows(block, count, target.len());
            let part: Vec<&[f64]> = columns.iter().map(|column| &column[rows.clone()]).collect();
            gram.replace(first, &part, &target[rows]);
        }
    }

    /// Keeps the first columns only.
    pub(crate) fn truncate(&mut self, columns: usize) {
        let kept: Vec<usize> = (0..columns).collect();
        self.0.iter_mut().for_each(|block| *block = block.chosen(&kept));
    }

    /// All rows together.
    pub(crate) fn total(&self) -> Gram {
        self.every(0, 1)
    }

    /// Every `step`-th stretch, beginning with the one at `start`.
    fn every(&self, start: usize, step: usize) -> Gram {
        let mut sum = Gram::empty(self.0.first().map_or(0, Gram::columns));
        self.0.iter().skip(start).step_by(step).for_each(|block| sum += block);
        sum
    }

    /// By how much the columns beyond the first `base` lower the squared error of stretches that were left out of the
    /// fit: mean over stretches (of signed roots) in standard errors of that mean.
    ///
    /// Every other stretch is predicted from the rest, then the other way round, with and without the further columns.
    pub(crate) fn evidence(&self, base: usize) -> f64 {
        let base: Vec<usize> = (0..base).collect();
        let mut gains = Vec::with_capacity(self.0.len());
        for parity in 0..2 {
            let fitted = self.every(parity, 2);
            let (with, without) = (fitted.solve().coefficients, fitted.chosen(&base).solve().coefficients);
            gains.extend(self.0.iter().skip(1 - parity).step_by(2).map(|block| {
                let gain = block.left(&without) - block.left(&with);
                // Signed roots: one stretch where the rest of the model fails must not drown what the others say.
                gain.abs().sqrt().copysign(gain)
            }));
        }
        mean_in_errors(&gains)
    }

    /// Covariance of coefficients that were fitted to all stretches: their scatter from stretch to stretch, which allows for residuals
    /// that are correlated within a stretch and of varying size (a sandwich over clusters; Liang and Zeger,
    /// Biometrika 73, 1986, 13–22). `taken` is the degrees of freedom that the fit took of them.
    pub(crate) fn covariance(&self, solution: &Solution, taken: usize) -> DMatrix<f64> {
        let count = solution.coefficients.len();
        let mut scatter = DMatrix::zeros(count, count);
        for block in &self.0 {
            let score = block.scores(&solution.coefficients);
            scatter += &score * score.transpose();
        }
        let freedom = self.0.len() as f64 / self.0.len().saturating_sub(taken).max(1) as f64;
        &solution.inverse * scatter * &solution.inverse * freedom
    }
}

fn rows(block: usize, count: usize, rows: usize) -> Range<usize> {
    block * rows / count..(block + 1) * rows / count
}
