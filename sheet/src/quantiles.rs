//! Quantiles by which an interval is wider or narrower than that of 95 %.

use statrs::distribution::{ContinuousCDF, Normal, StudentsT};

/// Quantile of Student's t distribution for a probability; with infinite degrees of freedom, of the normal distribution.
pub(crate) fn student_quantile(probability: f64, degrees_of_freedom: f64) -> f64 {
    let quantile = if degrees_of_freedom.is_infinite() {
        Normal::new(0.0, 1.0).ok().map(|normal| normal.inverse_cdf(probability))
    } else {
        StudentsT::new(0.0, 1.0, degrees_of_freedom).ok().map(|student| student.inverse_cdf(probability))
    };
    quantile.unwrap_or(f64::INFINITY)
}
