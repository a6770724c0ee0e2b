//! Statistics, each written once: quantiles, spreads, and means with their errors.
//!
//! Takes plain numbers and knows nothing of knobs. Every 95 % interval of the workspace takes its factor from here:
//! [`NORMAL_95`] where a standard deviation is known, [`student_95`] where it was itself estimated.

mod weighted;

use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::vector::{self, dot};

pub use weighted::Estimated;
pub(crate) use weighted::{between, combined, wrapped};

/// Two-sided 95 % of a normal distribution, in standard deviations.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Median of the magnitude of normal numbers, in standard deviations.
pub(crate) const MEDIAN_MAGNITUDE: f64 = 0.674_489_750_196_082;
/// Degrees of freedom from which Student's distribution is the normal one to ten digits.
const MANY: f64 = 1e6;

/// Two-sided 95 % of Student's distribution, in estimated standard deviations; infinite without a degree of freedom.
#[must_use]
pub fn student_95(degrees_of_freedom: f64) -> f64 {
    if degrees_of_freedom >= MANY {
        return NORMAL_95;
    }
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(f64::INFINITY, |law| law.inverse_cdf(0.975))
}

/// Mean of the values in its standard errors, as their own scatter shows these: how surely they are not zero on average.
pub(crate) fn mean_in_errors(values: &[f64]) -> f64 {
    let (mean, error) = mean_and_error(values);
    mean / error.max(f64::MIN_POSITIVE)
}

/// Mean of the values and its standard error from their own scatter; one value alone has no error.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (mean, (squares / (count * (count - 1.0).max(1.0))).sqrt())
}

/// Root of the mean square.
pub(crate) fn rms(values: &[f64]) -> f64 {
    (dot(values, values) / values.len().max(1) as f64).sqrt()
}

/// Distance between the smallest and the largest value.
pub(crate) fn span(values: &[f64]) -> f64 {
    vector::extent(values).map_or(0.0, |(low, high)| high - low)
}

/// Median of the values, which are reordered; 0 for none.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// Median distance of two neighbours: the period of samples, some of which may be missing; 0 for fewer than two.
pub(crate) fn median_step(values: &[f64]) -> f64 {
    median(&mut values.windows(2).map(|pair| pair[1] - pair[0]).collect::<Vec<_>>())
}

/// Value below which the given share of the values lies; reorders them; 0 for none.
pub(crate) fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = (share * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// Fourth differences of white noise over its standard deviation, as the median of their magnitudes shows it.
pub(crate) fn fourth_differences_of_noise() -> f64 {
    // Fourth differences raise the variance 70-fold.
    MEDIAN_MAGNITUDE * 70_f64.sqrt()
}

/// Standard deviation of white noise as the fourth differences show it; motion hardly shows there.
pub(crate) fn scatter(signal: &[f64]) -> f64 {
    let mut fourth: Vec<f64> =
        signal.windows(5).map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()).collect();
    median(&mut fourth) / fourth_differences_of_noise()
}

#[cfg(test)]
mod tests {
    use super::student_95;

    #[test]
    fn the_factor_of_a_95_percent_interval_is_students() {
        let table = [(1.0, 12.706), (2.0, 4.303), (5.0, 2.571), (29.0, 2.045), (31.0, 2.040), (60.0, 2.000)];
        for (freedom, quantile) in table.into_iter().chain([(1e5, 1.960), (1e7, 1.960), (f64::INFINITY, 1.960)]) {
            let found = student_95(freedom);
            assert!((found - quantile).abs() < 0.0006, "{found} for {freedom} degrees of freedom");
        }
        assert!(student_95(0.0).is_infinite());
    }
}
