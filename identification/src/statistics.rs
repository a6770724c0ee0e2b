//! Quantiles, and the factors between a standard deviation and a 95 % interval.

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::vector::dot;

/// Two-sided 95 % of the normal distribution, in standard deviations.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Share of a distribution below the upper end of a two-sided 95 % interval.
const UPPER_95: f64 = 0.975;
/// Median of the magnitudes of normal values, in standard deviations.
pub const MEDIAN_MAGNITUDE: f64 = 0.674_489_750_196_081_7;

/// Two-sided 95 % of Student's distribution with `degrees_of_freedom`, in standard deviations; infinite where there are
/// none.
///
/// ```
/// use identification::statistics::student_95;
///
/// // The tables' 12.706 for one degree of freedom, 2.042 for thirty.
/// assert!((student_95(1.0) - 12.706).abs() < 5e-4 && (student_95(30.0) - 2.042).abs() < 5e-4);
/// assert!(student_95(0.0).is_infinite());
/// ```
#[must_use]
pub fn student_95(degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom.is_infinite() {
        return NORMAL_95;
    }
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::INFINITY, |student| student.inverse_cdf(UPPER_95))
}

/// Median of the values, which are reordered; 0 for none.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let (middle, even) = (values.len() / 2, values.len().is_multiple_of(2));
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = if even { below.iter().copied().max_by(f64::total_cmp) } else { None };
    lower.map_or(*upper, |lower| 0.5 * (lower + *upper))
}

/// Value below which the given share of the values lies; reorders them; 0 for none.
#[allow(
    clippy::cast_precision_loss,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "an index between 0 and the length"
)]
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = (share * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// Root of the mean square; 0 for no values.
#[must_use]
pub fn rms(values: &[f64]) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "a number of samples")]
    let count = values.len().max(1) as f64;
    (dot(values, values) / count).sqrt()
}
