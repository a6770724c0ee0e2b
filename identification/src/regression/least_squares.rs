//! Linear least squares with collinear columns marked, lower bounds at zero, and robust intervals.

use std::ops::Deref;

use nalgebra::{DMatrix, DVector};

use super::gram::{COLLINEAR, Correction, Normal};
use crate::numerics::vector::{self, dot, square};
use crate::regression::leverage::Leverage;
use crate::regression::long_run;

/// A correction that would move the prediction by less than this share of the target is rounding, …
const SETTLED: f64 = 1e-15;
/// … and one by less than this share of the residual is a billionth of a standard deviation.
const NEGLIGIBLE: f64 = 1e-9;
/// Most rounds on the residual.
const ROUNDS: usize = 3;

/// Ridge that holds a coefficient of either sign near zero, as a share of its column's square: too small to matter unless
/// other columns explain the same.
const HELD: f64 = 1e-8;
/// The same for coefficients that cannot be negative.
const HELD_FIRMLY: f64 = 1e-11;

/// The solution of target ≈ Σ coefficient · column.
#[derive(Clone, Debug)]
pub(crate) struct LeastSquares {
    /// One per column; zero for those left out.
    pub(crate) coefficients: Vec<f64>,
    /// Target minus prediction, per row.
    pub(crate) residual: Vec<f64>,
    /// Inverse of the columns' Gram matrix, zero in the rows and columns of those left out.
    pub(crate) inverse: DMatrix<f64>,
    /// Columns that are sums of earlier ones, or empty.
    pub(crate) collinear: Vec<bool>,
    /// Columns held at zero because their coefficient would be negative.
    pub(crate) at_zero: Vec<bool>,
}

/// Covariance of coefficients for residuals of unknown autocorrelation and varying size.
pub(crate) struct RobustCovariance {
    pub(crate) matrix: DMatrix<f64>,
    /// Degrees of freedom of the variances, harmonic mean over the coefficients.
    pub(crate) degrees_of_freedom: f64,
    leverage: Leverage,
    /// Number of rows.
    rows: usize,
    /// The matrix that maps the scores to the coefficients.
    inverse: DMatrix<f64>,
}

impl RobustCovariance {
    /// Enlarges the covariance for `columns` further columns that were fitted but are not among those of the leverage.
    pub(crate) fn enlarge(&mut self, columns: usize) {
        self.matrix *= self.rows as f64 / self.rows.saturating_sub(columns).max(1) as f64;
    }

    /// Degrees of freedom with which the variance of Σ `derivatives`ⱼ·coefficientⱼ is known.
    pub(crate) fn degrees_of_freedom_of(&self, derivatives: &DVector<f64>) -> f64 {
        self.leverage.degrees_of_freedom(&self.inverse.tr_mul(derivatives))
    }
}

impl LeastSquares {
    /// Solves for `columns`, each as long as `target`, whose coefficients may have either sign.
    pub(crate) fn solve<C: Deref<Target = [f64]>>(columns: &[C], target: &[f64]) -> Self {
        Self::corrected(columns, target, &vec![false; columns.len()], &[])
    }

    /// The same with corrections of the normal equations; coefficients marked in `nonnegative` stay at or above zero.
    pub(crate) fn corrected<C: Deref<Target = [f64]>>(
        columns: &[C],
        target: &[f64],
        nonnegative: &[bool],
        corrections: &[Correction],
    ) -> Self {
        Self::of_products(columns, &vector::gram(columns), target, nonnegative, corrections, COLLINEAR)
    }

    /// [`Self::corrected`] for columns that may be linearly dependent.
    ///
    /// If they are, like an offset and two levels of friction, the coefficient that may have either sign is held near zero: it
    /// explains only what the others, at their bounds, cannot.
    pub(crate) fn held<C: Deref<Target = [f64]>>(
        columns: &[C],
        target: &[f64],
        nonnegative: &[bool],
        corrections: &[Correction],
    ) -> Self {
        let products = vector::gram(columns);
        let holds = nonnegative.iter().enumerate().map(|(column, nonnegative)| Correction {
            column,
            square: if *nonnegative { HELD_FIRMLY } else { HELD } * products[(column, column)],
            product: 0.0,
        });
        let corrections: Vec<Correction> = holds.chain(corrections.iter().copied()).collect();
        Self::of_products(columns, &products, target, nonnegative, &corrections, 0.0)
    }

    /// [`Self::corrected`] with the columns' inner products given, and the share of a column's square that must remain beside the
    /// earlier ones for it to be fitted.
    pub(crate) fn of_products<C: Deref<Target = [f64]>>(
        columns: &[C],
        products: &DMatrix<f64>,
        target: &[f64],
        nonnegative: &[bool],
        corrections: &[Correction],
        collinear: f64,
    ) -> Self {
        let count = columns.len();
        let with_target: Vec<f64> = columns.iter().map(|column| dot(column, target)).collect();
        let chosen: Vec<usize> = (0..count).collect();
        let normal =
            Normal { products, with_target: &with_target, chosen: &chosen, nonnegative, corrections, collinear };
        let mut residual = target.to_vec();
        let Some(mut solution) = normal.solve() else {
            let (coefficients, inverse) = (vec![0.0; count], DMatrix::zeros(count, count));
            return Self { coefficients, residual, inverse, collinear: vec![true; count], at_zero: vec![false; count] };
        };
        let size = square(target).sqrt();
        // Rounds on the residual win back the digits that the Gram matrix costs.
        for round in 1..=ROUNDS {
            let products = vector::residual(columns, &solution.coefficients, target, &mut residual);
            let settled = (SETTLED * size).max(NEGLIGIBLE * square(&residual).sqrt());
            if round == ROUNDS || solution.improve(&products, settled) {
                break;
            }
        }
        let is_fitted = |column: usize| solution.fitted.contains(&column);
        Self {
            residual,
            inverse: solution.inverse(),
            at_zero: chosen.iter().map(|column| !solution.collinear[*column] && !is_fitted(*column)).collect(),
            coefficients: solution.coefficients,
            collinear: solution.collinear,
        }
    }

    /// Sum of squares of the residual.
    pub(crate) fn squares(&self) -> f64 {
        square(&self.residual)
    }

    /// The columns that were fitted.
    fn active(&self) -> Vec<usize> {
        (0..self.coefficients.len()).filter(|column| !self.collinear[*column] && !self.at_zero[*column]).collect()
    }

    /// Number of columns that were fitted.
    pub(crate) fn fitted(&self) -> usize {
        self.active().len()
    }

    /// Rows beyond the number of columns that were fitted.
    fn freedom(&self) -> f64 {
        self.residual.len().saturating_sub(self.fitted()).max(1) as f64
    }

    /// Covariance of the coefficients if the residuals were independent and alike (the textbook's).
    pub(crate) fn textbook_covariance(&self) -> DMatrix<f64> {
        &self.inverse * (self.squares() / self.freedom())
    }

    /// The columns' products with the residual, row by row.
    fn scores<C: Deref<Target = [f64]>>(&self, columns: &[C]) -> Vec<Vec<f64>> {
        let score = |column: &C| column.iter().zip(&self.residual).map(|(value, left)| value * left).collect();
        columns.iter().map(score).collect()
    }

    /// Covariance of the coefficients for residuals of unknown autocorrelation and varying size.
    ///
    /// Newey and West's sandwich around the long-run covariance of the scores (`long_run`), enlarged by what the
    /// residuals have lost to the fit (`leverage`).
    pub(crate) fn robust<C: Deref<Target = [f64]>>(&self, columns: &[C]) -> RobustCovariance {
        let count = columns.len();
        let (middle, bandwidth) = long_run::covariance(&self.scores(columns));
        let active = self.active();
        let leverage = Leverage::of(columns, &active, bandwidth);
        let factor = &self.inverse * leverage.correction();
        let mut robust = RobustCovariance {
            matrix: &factor * middle * factor.transpose(),
            degrees_of_freedom: f64::INFINITY,
            leverage,
            rows: self.residual.len(),
            inverse: self.inverse.clone(),
        };
        let unit = |index: &usize| DVector::from_fn(count, |row, _| if row == *index { 1.0 } else { 0.0 });
        let shares = active.iter().map(|index| 1.0 / robust.degrees_of_freedom_of(&unit(index)));
        let (sum, fitted) = shares.fold((0.0, 0.0), |(sum, fitted), share| (sum + share, fitted + 1.0));
        if sum > 0.0 {
            robust.degrees_of_freedom = fitted / sum;
        }
        robust
    }

    /// Robust covariance where the columns from `first` on are the many points of curves: enlarged by rows over degrees of freedom. The cost of
    /// the leverage that [`Self::robust`] takes instead grows with the fourth power of the number of columns.
    ///
    /// A point that few passes cross has few scores, and the fit has shrunk them: its variance is at least the textbook's.
    pub(crate) fn robust_of_points<C: Deref<Target = [f64]>>(&self, columns: &[C], first: usize) -> DMatrix<f64> {
        let (middle, _) = long_run::covariance(&self.scores(columns));
        let mut robust = &self.inverse * middle * &self.inverse * (self.residual.len() as f64 / self.freedom());
        let even = self.textbook_covariance();
        for place in first..columns.len() {
            robust[(place, place)] = robust[(place, place)].max(even[(place, place)]);
        }
        robust
    }

    /// Robust standard deviation of one coefficient, estimated from the one series of scores on which it depends.
    pub(crate) fn robust_deviation<C: Deref<Target = [f64]>>(&self, columns: &[C], coefficient: usize) -> f64 {
        let rows = self.residual.len();
        let shares: Vec<f64> = (0..columns.len()).map(|column| -self.inverse[(coefficient, column)]).collect();
        let influence = residual(columns, &vec![0.0; rows], &shares);
        let (square, _) = long_run::covariance(&self.scores(&[influence]));
        (square[(0, 0)] * (rows as f64 / self.freedom())).sqrt()
    }
}

/// Target minus Σ coefficient · column.
pub(crate) fn residual<C: Deref<Target = [f64]>>(columns: &[C], target: &[f64], coefficients: &[f64]) -> Vec<f64> {
    let mut residual = vec![0.0; target.len()];
    vector::residual(columns, coefficients, target, &mut residual);
    residual
}
