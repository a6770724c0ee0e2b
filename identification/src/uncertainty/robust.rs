//! Covariances of coefficients: the textbook's, and one that holds for the residuals of real sensors.

use std::ops::Deref;

use nalgebra::{DMatrix, DVector};

use super::leverage::Leverage;
use super::long_run::{kernel_scale, smooth_scores};
use crate::regression::LeastSquares;
use crate::vector::{self, dot};

/// Covariance of coefficients for residuals of unknown autocorrelation and varying size.
pub(crate) struct RobustCovariance {
    pub(crate) matrix: DMatrix<f64>,
    /// Degrees of freedom with which the variances are known, harmonic mean over the coefficients.
    pub(crate) degrees_of_freedom: f64,
    leverage: Leverage,
    /// What takes the scores to the coefficients.
    inverse: DMatrix<f64>,
}

impl RobustCovariance {
    /// Degrees of freedom with which the variance of Σ `derivatives`ⱼ·coefficientⱼ is known.
    pub(crate) fn degrees_of_freedom_of(&self, derivatives: &DVector<f64>) -> f64 {
        self.leverage.degrees_of_freedom(&self.inverse.tr_mul(derivatives))
    }
}

impl LeastSquares {
    /// Covariance of the coefficients if the residuals were independent and alike (the textbook's).
    pub(crate) fn textbook_covariance(&self) -> DMatrix<f64> {
        let freedom = self.residual.len().saturating_sub(self.fitted().len()).max(1) as f64;
        &self.inverse * (self.squares() / freedom)
    }

    /// Covariance of the coefficients for residuals of unknown autocorrelation and varying size.
    ///
    /// Newey and West's sandwich around the long-run covariance of the scores (`long_run`), enlarged by what the
    /// residuals have lost to the fit (`leverage`).
    pub(crate) fn robust<C: Deref<Target = [f64]>>(&self, columns: &[C]) -> RobustCovariance {
        let count = columns.len();
        let scores: Vec<Vec<f64>> = columns.iter().map(|column| vector::multiply(column, &self.residual)).collect();
        let (smooth, width, bandwidth) = smooth_scores(&scores);
        let mut middle = DMatrix::zeros(count, count);
        vector::products(&smooth, 0, &mut middle);
        let active = self.fitted();
        let leverage = Leverage::of(columns, &active, bandwidth);
        let factor = &self.inverse * leverage.correction();
        let mut robust = RobustCovariance {
            matrix: &factor * middle * factor.transpose() * kernel_scale(width),
            degrees_of_freedom: f64::INFINITY,
            leverage,
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

    /// Standard deviation of one coefficient, estimated likewise from the one series that it depends on.
    pub(crate) fn robust_deviation<C: Deref<Target = [f64]>>(&self, columns: &[C], coefficient: usize) -> f64 {
        let rows = self.residual.len();
        let shares: Vec<f64> = (0..columns.len()).map(|column| -self.inverse[(coefficient, column)]).collect();
        let mut influence = vec![0.0; rows];
        vector::residual(columns, &shares, &influence.clone(), &mut influence);
        let score = vector::multiply(&influence, &self.residual);
        let (smooth, width, _) = smooth_scores(&[score]);
        let freedom = rows as f64 / rows.saturating_sub(self.fitted().len()).max(1) as f64;
        (dot(&smooth[0], &smooth[0]) * kernel_scale(width) * freedom).sqrt()
    }
}
