//! Least squares over rows.

use std::ops::Deref;

use nalgebra::DMatrix;

use super::gram::{Collinear, Gram, Solution};
use crate::vector::{self, dot};

/// Noise of a column, in sums over the rows.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ColumnNoise {
    pub(crate) column: usize,
    /// What it adds to the column's square.
    pub(crate) square: f64,
    /// What it adds to the column's product with the target.
    pub(crate) product: f64,
}

/// Noise of a column may make up at most this share of its square to be taken off: beyond, nothing would be left.
const MOST_NOISE: f64 = 0.5;

/// The solution of target ≈ Σ coefficient · column, with what it leaves.
#[derive(Clone, Debug)]
pub(crate) struct LeastSquares {
    /// See [`Solution`].
    pub(crate) coefficients: Vec<f64>,
    /// See [`Solution`].
    pub(crate) inverse: DMatrix<f64>,
    /// See [`Solution`].
    pub(crate) collinear: Vec<bool>,
    /// See [`Solution`].
    pub(crate) at_zero: Vec<bool>,
    /// Target minus prediction, per row.
    pub(crate) residual: Vec<f64>,
}

impl LeastSquares {
    /// Solves for `columns` (each as long as `target`), of either sign.
    pub(crate) fn solve<C: Deref<Target = [f64]>>(columns: &[C], target: &[f64]) -> Self {
        Self::solve_noisy(columns, &Gram::of(columns, target), target, &[], &[])
    }

    /// The same with coefficients that stay at or above zero, and collinear columns held small.
    pub(crate) fn solve_held<C: Deref<Target = [f64]>>(columns: &[C], target: &[f64], nonnegative: &[bool]) -> Self {
        let solution = Gram::of(columns, target).solve_held(nonnegative);
        let residual = residual(columns, target, &solution.coefficients);
        Self::with(solution, residual)
    }

    /// The same with the inner products given and the sums that `noise` gives taken off the normal equations.
    pub(crate) fn solve_noisy<C: Deref<Target = [f64]>>(
        columns: &[C],
        gram: &Gram,
        target: &[f64],
        nonnegative: &[bool],
        noise: &[ColumnNoise],
    ) -> Self {
        let mut gram = gram.clone();
        let noise: Vec<&ColumnNoise> =
            noise.iter().filter(|noise| noise.square < MOST_NOISE * gram.square(noise.column)).collect();
        noise.iter().for_each(|noise| gram.take_off(noise.column, noise.square, noise.product));
        let mut left = target.to_vec();
        let solution = gram.solve_with(Collinear::LeftOut, nonnegative, |coefficients| {
            let mut products = vector::residual(columns, coefficients, target, &mut left);
            for noise in &noise {
                products[noise.column] += noise.square * coefficients[noise.column] - noise.product;
            }
            Some((products, dot(&left, &left).sqrt()))
        });
        if solution.coefficients.iter().all(|coefficient| *coefficient == 0.0) {
            left.copy_from_slice(target);
        }
        Self::with(solution, left)
    }

    fn with(solution: Solution, residual: Vec<f64>) -> Self {
        let Solution { coefficients, inverse, collinear, at_zero } = solution;
        Self { coefficients, inverse, collinear, at_zero, residual }
    }

    /// The same fit by instrumental variables: the residual is made orthogonal to the `instruments`, one per column,
    /// which noise in the columns then does not bias. The robust covariance wants the instruments.
    pub(crate) fn instrumented<C: Deref<Target = [f64]>>(
        self,
        columns: &[C],
        instruments: &[C],
        target: &[f64],
    ) -> Self {
        let active = self.fitted();
        let size = |columns: &[C], index: usize| dot(&columns[index], &columns[index]).sqrt();
        let cross = DMatrix::from_fn(active.len(), active.len(), |row, column| {
            let (row, column) = (active[row], active[column]);
            dot(&instruments[row], &columns[column]) / (size(instruments, row) * size(columns, column))
        });
        let Some(inverse) = cross.try_inverse() else { return self };
        let mut solution = self;
        solution.inverse.fill(0.0);
        solution.coefficients.fill(0.0);
        for (row, at) in active.iter().enumerate() {
            for (column, other) in active.iter().enumerate() {
                let share = inverse[(row, column)] / (size(columns, *at) * size(instruments, *other));
                solution.inverse[(*at, *other)] = share;
                solution.coefficients[*at] += share * dot(&instruments[*other], target);
            }
        }
        solution.residual = residual(columns, target, &solution.coefficients);
        solution
    }

    /// Sum of squares left.
    pub(crate) fn squares(&self) -> f64 {
        dot(&self.residual, &self.residual)
    }

    /// Whether it leaves less than another solution of the same target.
    pub(crate) fn improves(&self, other: &Self) -> bool {
        self.squares() < (1.0 - 1e-6) * other.squares()
    }

    /// Indices of the columns that were fitted.
    pub(crate) fn fitted(&self) -> Vec<usize> {
        (0..self.coefficients.len()).filter(|index| !self.collinear[*index] && !self.at_zero[*index]).collect()
    }
}

/// Target minus the columns' sum.
pub(crate) fn residual<C: Deref<Target = [f64]>>(columns: &[C], target: &[f64], coefficients: &[f64]) -> Vec<f64> {
    let mut residual = target.to_vec();
    for (column, coefficient) in columns.iter().zip(coefficients).filter(|(_, coefficient)| **coefficient != 0.0) {
        residual.iter_mut().zip(column.iter()).for_each(|(left, value)| *left -= coefficient * value);
    }
    residual
}

#[cfg(test)]
mod tests {
    use super::LeastSquares;

    #[test]
    fn sorting_the_samples_by_position_changes_nothing() {
        let angle: Vec<f64> = (0..500).map(|n| (f64::from(n) * 0.37).sin()).collect();
        let velocity: Vec<f64> = (0..500).map(|n| (f64::from(n) * 0.37).cos()).collect();
        let torque: Vec<f64> = (0..500)
            .map(|n| 2.0 * angle[n] + 0.5 * velocity[n] + 0.1 * f64::from(u32::try_from(n * n % 17).unwrap_or(0)))
            .collect();
        let mut order: Vec<usize> = (0..500).collect();
        order.sort_by(|a, b| angle[*a].total_cmp(&angle[*b]));
        let sorted = |values: &[f64]| order.iter().map(|index| values[*index]).collect::<Vec<f64>>();
        let in_time = LeastSquares::solve(&[angle.clone(), velocity.clone()], &torque);
        let by_angle = LeastSquares::solve(&[sorted(&angle), sorted(&velocity)], &sorted(&torque));
        for (left, right) in in_time.coefficients.iter().zip(&by_angle.coefficients) {
            assert!((left - right).abs() < 1e-12, "{left} in time, {right} by position");
        }
        let difference = in_time.textbook_covariance() - by_angle.textbook_covariance();
        assert!(difference.norm() < 1e-12 * in_time.textbook_covariance().norm());
    }
}
