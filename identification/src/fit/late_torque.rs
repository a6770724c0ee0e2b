//! Estimates that allow for a late torque.

use nalgebra::DMatrix;

use super::omitted::{Beside, Omitted};
use super::shift::Shift;
use super::trimmed::Trimmed;
use crate::numerics::interpolation::advance;
use crate::numerics::lag::{lagged, prompt};
use crate::numerics::vector::{self, dot, square};
use crate::regression::least_squares::{LeastSquares, residual};
use crate::regression::problem::Problem;

/// Steps in which a delay is found.
const DELAY_STEPS: usize = 3;
/// A shorter lag takes less than a ten-thousandth off the fastest torques of the band.
const LEAST_LAG_ROWS: f64 = 0.004;
/// A lag counts as likely too if its sum of squares exceeds a delay's by at most this many mean squares of a row: two nats.
const WORSE_BY: f64 = 4.0;

/// The shifts of the estimates if the torque is delayed as a whole, and if it lags behind a first-order low-pass, which also attenuates fast
/// torques. The delay's column is linear and not enough for a long delay; the torque before a lag is exactly the received one plus slope · lag.
pub(super) fn shifts(trimmed: &Trimmed<'_>, torque_mnm: &[f64], robust: &DMatrix<f64>) -> Vec<Shift> {
    let Trimmed { problem: Problem { row_filter, .. }, solution, .. } = trimmed;
    let rate_hz = row_filter.rate_hz;
    let delay_s = trimmed.delay.as_ref().map_or(trimmed.delay_s, |delay| delay.delay_s);
    let is_long = trimmed.delay.is_some() && delay_s.abs() * rate_hz >= 1.0;
    let lag_rows = delay_s * rate_hz / row_filter.step as f64;
    let mut shifts = Vec::new();
    // With measured curves, the aligned torque would have to be projected off them, as the fitted torque was.
    if trimmed.curves.is_some() || !is_long && lag_rows < LEAST_LAG_ROWS {
        return shifts;
    }
    let fitted = solution.squares();
    let (beside, least) = match &trimmed.delay {
        Some(delay) => {
            let omitted = Omitted { column: delay.column.clone(), is_beyond_friction: false };
            let beside = Beside::of(&omitted, trimmed).filter(|beside| beside.is_separable);
            let Some(beside) = beside else { return shifts };
            let delayed = |delay_s: f64| row_filter.rows(&advance(torque_mnm, delay_s * rate_hz));
            let (shift, left, _) = aligned(trimmed, robust, delay_s, Some(&beside), delayed);
            if is_long && square(&left) < fitted {
                shifts.push(shift);
            }
            (Some(beside), square(&left))
        }
        None => (None, fitted),
    };
    if lag_rows >= LEAST_LAG_ROWS {
        let ahead = |lag_s: f64| row_filter.rows(&prompt(torque_mnm, lag_s, rate_hz));
        let (shift, left, lag_s) = aligned(trimmed, robust, delay_s, beside.as_ref(), ahead);
        // The slope adds noise. Behind the lag the residual is as noisy as that of the received torque, so that the sums of squares compare.
        let left = lagged(&left, lag_s * rate_hz / row_filter.step as f64);
        if square(&left) < least * (1.0 + WORSE_BY / left.len() as f64) {
            shifts.push(shift);
        }
    }
    shifts
}

/// The shift of the estimates with the torque aligned by `delay_s`, the residual and the delay, which is refined if its column is given in
/// `beside`.
fn aligned(
    Trimmed { columns, target, solution, .. }: &Trimmed<'_>,
    robust: &DMatrix<f64>,
    mut delay_s: f64,
    beside: Option<&Beside>,
    align: impl Fn(f64) -> Vec<f64>,
) -> (Shift, Vec<f64>, f64) {
    let mut steps = if beside.is_some() { DELAY_STEPS } else { 1 };
    loop {
        let aligned = align(delay_s);
        let moved: Vec<f64> = aligned.iter().zip(&**target).map(|(aligned, target)| aligned - target).collect();
        let change = &solution.inverse * vector::products_with(columns, &moved);
        let coefficients: Vec<f64> = solution.coefficients.iter().zip(&change).map(|(one, more)| one + more).collect();
        let left = residual(columns, &aligned, &coefficients);
        steps -= 1;
        match beside {
            Some(Beside { rest, .. }) if steps > 0 => delay_s += dot(rest, &left) / square(rest),
            _ => {
                let of_delay = beside.map(|Beside { rest, change, .. }| {
                    let variance = LeastSquares::solve(&[&**rest], &left).robust_of_points(&[&**rest], 1)[(0, 0)];
                    variance * change * change.transpose()
                });
                let covariance = of_delay.map_or_else(|| robust.clone(), |of_delay| robust + of_delay);
                return (Shift { change, covariance, is_of_better_model: true }, left, delay_s);
            }
        }
    }
}
