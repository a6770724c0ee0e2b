//! Other estimates of the same parameters.

use nalgebra::{DMatrix, DVector};

use super::trimmed::{Rows, Trimmed};
use crate::regression::least_squares::LeastSquares;

/// Other estimates of the coefficients.
pub(super) struct Shift {
    pub(super) change: DVector<f64>,
    /// Covariance of the other estimates.
    pub(super) covariance: DMatrix<f64>,
    /// Whether they are estimates of a better model, and not only of other rows.
    pub(super) is_of_better_model: bool,
}

impl Shift {
    /// The estimates from `rows` passed through `change`, with the coefficients marked in `at_zero` held at zero; `None` if the rows
    /// do not determine all of the others.
    pub(super) fn of(
        trimmed: &Trimmed<'_>,
        Rows { columns, target }: &Rows,
        at_zero: &[bool],
        change: impl Fn(&[f64]) -> Vec<f64>,
    ) -> Option<Self> {
        let solution = &trimmed.solution;
        let is_fitted = |index: usize| !solution.collinear[index] && !at_zero[index];
        let target = change(target);
        let columns: Vec<Vec<f64>> = columns
            .iter()
            .enumerate()
            .map(|(index, column)| if is_fitted(index) { change(column) } else { vec![0.0; target.len()] })
            .collect();
        let other = LeastSquares::solve(&columns, &target);
        if (0..columns.len()).any(|index| is_fitted(index) && other.collinear[index]) {
            return None;
        }
        let covariance = other.robust_of_points(&columns, columns.len());
        let change = DVector::from_iterator(
            columns.len(),
            other.coefficients.iter().zip(&solution.coefficients).map(|(other, fitted)| other - fitted),
        );
        Some(Self { change, covariance, is_of_better_model: false })
    }
}
