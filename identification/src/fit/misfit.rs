//! How far the estimates move between fits that would agree if the model were right.
//!
//! An interval that allows for correlated residuals holds if the model is right. On a real machine the model seldom is: there
//! may be a weight, a spring, friction that rises from near zero speed, a late torque, a band in which something rings. The
//! parameters then depend on the speeds and frequencies to which they were fitted. They are fitted again with the rows next to
//! where the knob turns round without a rest, which the fit leaves out since its filters reach across; to half the band; to the
//! faster and to the slower half of the motion; beside effects that the model lacks (`omitted.rs`); and with a late torque
//! (`late_torque.rs`). Where an estimate moves by more than chance explains (J. A. Hausman, Econometrica 46, 1978, 1251–1271),
//! its interval reaches to the other estimate.

use nalgebra::{DMatrix, RowDVector};

use super::shift::Shift;
use super::trimmed::{Rows, Trimmed};
use super::{late_torque, omitted};
use crate::numerics::statistics::{NORMAL_95, deviation_of_sum, interval, median};
use crate::preparation::row_filter::{ROWS_PER_EDGE, row_low_pass};
use crate::regression::problem::Problem;

/// Share of the band that the narrower fit keeps, and every how many of its rows.
const NARROWER: f64 = 0.5;
const EVERY: usize = 2;
/// Least variance of the difference of two estimates, as a share of the other estimate's variance.
const LEAST_VARIANCE: f64 = 0.25;
/// Two-sided 95 % of the normal distribution shared among twelve better models (Bonferroni), in standard deviations.
const SHARED_95: f64 = 2.86;
/// One-sided 95 % of the normal distribution, in standard deviations.
const ONE_SIDED_95: f64 = 1.645;

/// Other estimates of the same parameters, as their differences from the fit.
pub(crate) struct Misfit {
    /// From other rows, or beside other effects.
    others: Vec<Shift>,
    /// Without the bounds at zero, where the fit held a coefficient there.
    unbounded: Option<Shift>,
    /// What the model clearly lacks.
    pub(super) note: Option<String>,
}

impl Misfit {
    /// Fits the settled problem's columns to the rows with those `near` standstill, to half their band, to the faster and the
    /// slower half of their motion, and beside omitted effects. `robust` is the covariance of the fit.
    pub(crate) fn of(trimmed: &Trimmed<'_>, torque_mnm: &[f64], robust: &DMatrix<f64>, near: Option<&Rows>) -> Self {
        let at_zero = &trimmed.solution.at_zero;
        let is_held = at_zero.contains(&true);
        let Problem { motion, row_filter, target, .. } = &trimmed.problem;
        let speeds: Vec<f64> =
            (0..target.len()).map(|row| motion.velocity_rad_s[row * row_filter.step].abs()).collect();
        let typical = median(&mut speeds.clone());
        let narrow = row_low_pass(NARROWER, ROWS_PER_EDGE);
        let fitted = Rows { columns: trimmed.columns.clone(), target: trimmed.target.clone() };
        let rows = near.unwrap_or(&fitted);
        let whole = |rows: &Rows| Shift::of(trimmed, rows, at_zero, <[f64]>::to_vec);
        let where_speed = |is_kept: fn(f64, f64) -> bool| {
            let kept = |rows: &[f64]| {
                let with_speeds = rows.iter().zip(&speeds).filter(|(_, speed)| is_kept(**speed, typical));
                with_speeds.map(|(value, _)| *value).collect()
            };
            Shift::of(trimmed, rows, at_zero, kept)
        };
        let shifts = [
            near.and_then(whole),
            Shift::of(trimmed, rows, at_zero, |rows| narrow.decimate(rows, EVERY)),
            where_speed(|speed, typical| speed > typical),
            where_speed(|speed, typical| speed <= typical),
        ];
        let is_free = vec![false; at_zero.len()];
        let unbounded = is_held.then(|| Shift::of(trimmed, &fitted, &is_free, <[f64]>::to_vec)).flatten();
        let (beside_omitted, note) = omitted::shifts(trimmed, robust);
        let others = shifts.into_iter().flatten().chain(beside_omitted);
        Self { others: others.chain(late_torque::shifts(trimmed, torque_mnm, robust)).collect(), unbounded, note }
    }

    /// Half width of the 95 % interval of Σ `derivatives`ⱼ·coefficientⱼ, whose half width and variance from the fit alone are
    /// `by_chance` and `fitted`.
    pub(crate) fn half_width(&self, derivatives: &RowDVector<f64>, by_chance: f64, fitted: f64) -> f64 {
        let beyond = self.others.iter().map(|Shift { change, covariance, is_of_better_model }| {
            let other = (derivatives * covariance).dot(derivatives);
            // By chance alone, the variance of the estimates' difference is the difference of their variances (Hausman).
            let chance = (other - fitted).max(LEAST_VARIANCE * other);
            // After a clear shift the truth lies near the better model's estimate, whose own uncertainty is covered too.
            let (critical, about) =
                if *is_of_better_model { (SHARED_95, ONE_SIDED_95 * other.sqrt()) } else { (NORMAL_95, 0.0) };
            let beyond = (derivatives.transpose().dot(change).powi(2) - critical.powi(2) * chance).max(0.0).sqrt();
            beyond * (beyond + 2.0 * about)
        });
        (by_chance.powi(2) + beyond.fold(0.0, f64::max)).sqrt()
    }

    /// Lowest and highest change of Σ `derivatives`ⱼ·coefficientⱼ in the 95 % interval of the fit without bounds; `None` where
    /// no coefficient is held at zero. What the bound takes from one coefficient it gives to others.
    pub(crate) fn without_bounds(&self, derivatives: &RowDVector<f64>, critical: f64) -> Option<[f64; 2]> {
        let Shift { change, covariance, .. } = self.unbounded.as_ref()?;
        let change = derivatives.transpose().dot(change);
        let half = critical * deviation_of_sum(covariance, derivatives.as_slice());
        Some(interval(change, half))
    }
}
