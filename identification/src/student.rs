//! Student's distribution.

use crate::long_run::NORMAL_95;

/// Two-sided 95 % of Student's distribution, by its expansion about the normal one (Abramowitz and Stegun 26.7.5);
/// 1 % short for two degrees of freedom, better for more.
pub(crate) fn student_95(freedom: f64) -> f64 {
    let z = NORMAL_95;
    let terms = [
        (z.powi(3) + z) / 4.0,
        (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0,
        (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0,
        (79.0 * z.powi(9) + 776.0 * z.powi(7) + 1482.0 * z.powi(5) - 1920.0 * z.powi(3) - 945.0 * z) / 92160.0,
    ];
    terms.iter().rev().fold(0.0, |sum, term| (sum + term) / freedom) + z
}

#[cfg(test)]
mod tests {
    use super::student_95;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, quantile, tolerance) in [(2.0, 4.303, 0.05), (5.0, 2.571, 0.002), (30.0, 2.042, 0.001)] {
            let found = student_95(freedom);
            assert!((found - quantile).abs() < tolerance, "{found} for {freedom} degrees of freedom");
        }
    }
}
