//! Whether a process keeps its parts within their limits: Cp and Cpk, Pp and Ppk, with intervals.

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use statrs::function::gamma::ln_gamma;

use crate::noise::mean_and_deviation;
use crate::specification::Limits;

/// Mean range of two normal values, in standard deviations.
const RANGE_OF_TWO: f64 = std::f64::consts::FRAC_2_SQRT_PI;
/// Degrees of freedom of a standard deviation from moving ranges, per value less one (J. D. Cryer, T. P. Ryan, J. Qual.
/// Technol. 22, 1990, 187–192).
const OF_MOVING_RANGES: f64 = 0.605;

/// What a process can hold, by values in the order in which they were made.
///
/// Formulas: NIST/SEMATECH e-Handbook, 6.1.6; intervals of Cp by the distribution of the variance, of Cpk by A. F. Bissell, Appl.
/// Statist. 39, 1990, 331–340.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Capability {
    /// Number of values.
    pub number: usize,
    /// Values in a subgroup; 1 where there are none.
    pub subgroup: usize,
    /// Mean of all values.
    pub mean: f64,
    /// Standard deviation within subgroups, or from moving ranges of single values: over a short time.
    pub deviation_within: f64,
    /// Standard deviation of all values: over the whole time.
    pub deviation_overall: f64,
    /// Cp: distance of the limits over six deviations within; `None` with one limit.
    pub cp: Option<Index>,
    /// Cpk: distance from the mean to the nearer limit over three deviations within.
    pub cpk: Index,
    /// Pp: as Cp, with the overall deviation.
    pub pp: Option<Index>,
    /// Ppk: as Cpk, with the overall deviation.
    pub ppk: Index,
}

/// An index with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Index {
    /// Its value.
    pub value: f64,
    /// Its 95 % interval.
    pub ci95: [f64; 2],
}

/// Why there is no capability.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CapabilityError {
    /// Too few values.
    #[error("{0} values are too few for a capability; give at least two subgroups, or four single values")]
    TooFew(usize),
    /// The values do not fill subgroups.
    #[error("{number} values cannot be divided into subgroups of {subgroup}")]
    Uneven {
        /// Number of values.
        number: usize,
        /// Values in a subgroup.
        subgroup: usize,
    },
    /// All values are equal.
    #[error("all values are equal: their deviation is zero, so there is no index")]
    NoDeviation,
    /// No limits.
    #[error("there are no limits")]
    NoLimit,
}

impl Capability {
    /// The capability from values in the order in which they were made, in consecutive subgroups of `subgroup` values; 1 for single values.
    ///
    /// # Errors
    /// [`CapabilityError`], a sentence on the values.
    pub fn of(values: &[f64], subgroup: usize, limits: Limits) -> Result<Self, CapabilityError> {
        let number = values.len();
        if subgroup == 0 || !number.is_multiple_of(subgroup) {
            return Err(CapabilityError::Uneven { number, subgroup });
        }
        if number < 2 * subgroup.max(2) {
            return Err(CapabilityError::TooFew(number));
        }
        let (mean, deviation_overall) = mean_and_deviation(values).ok_or(CapabilityError::TooFew(number))?;
        let (deviation_within, freedom) = if subgroup == 1 { moving_ranges(values) } else { pooled(values, subgroup) };
        if deviation_within <= 0.0 || deviation_overall <= 0.0 {
            return Err(CapabilityError::NoDeviation);
        }
        let nearest = [limits.min.map(|min| mean - min), limits.max.map(|max| max - mean)];
        let nearest = nearest.into_iter().flatten().reduce(f64::min).ok_or(CapabilityError::NoLimit)?;
        let width = limits.min.zip(limits.max).map(|(min, max)| max - min);
        let two_sided =
            |deviation: f64, freedom| width.map(|width| Index::of_width(width / (6.0 * deviation), freedom));
        let one_sided =
            |deviation: f64, freedom| Index::of_distance(nearest / (3.0 * deviation), number as f64, freedom);
        let overall = number as f64 - 1.0;
        Ok(Self {
            number,
            subgroup,
            mean,
            deviation_within,
            deviation_overall,
            cp: two_sided(deviation_within, freedom),
            cpk: one_sided(deviation_within, freedom),
            pp: two_sided(deviation_overall, overall),
            ppk: one_sided(deviation_overall, overall),
        })
    }
}

/// Standard deviation estimated from the mean moving range, and its degrees of freedom.
fn moving_ranges(values: &[f64]) -> (f64, f64) {
    let steps = values.len() as f64 - 1.0;
    let mean = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>() / steps;
    (mean / RANGE_OF_TWO, OF_MOVING_RANGES * steps)
}

/// Pooled deviation within subgroups without its bias, and its degrees of freedom.
fn pooled(values: &[f64], subgroup: usize) -> (f64, f64) {
    let squares: f64 = values
        .chunks(subgroup)
        .filter_map(mean_and_deviation)
        .map(|(_, deviation)| deviation.powi(2) * (subgroup as f64 - 1.0))
        .sum();
    let freedom = (values.len() / subgroup * (subgroup - 1)) as f64;
    // c₄ of as many values as have these degrees of freedom.
    let bias = (2.0 / freedom).sqrt() * (ln_gamma(0.5 * (freedom + 1.0)) - ln_gamma(0.5 * freedom)).exp();
    ((squares / freedom).sqrt() / bias, freedom)
}

impl Index {
    fn of_width(value: f64, freedom: f64) -> Self {
        let ends = ChiSquared::new(freedom)
            .map_or([f64::NAN; 2], |chi| [0.025, 0.975].map(|share| value * (chi.inverse_cdf(share) / freedom).sqrt()));
        Self { value, ci95: ends }
    }

    fn of_distance(value: f64, number: f64, freedom: f64) -> Self {
        let error = (1.0 / (9.0 * number) + value.powi(2) / (2.0 * freedom)).sqrt();
        let half = identification::statistics::NORMAL_95 * error;
        Self { value, ci95: [value - half, value + half] }
    }
}
