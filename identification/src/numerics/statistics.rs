//! Quantiles, intervals, means, noise and ranks of values, and means on the circle.

use std::borrow::Borrow;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::numerics::vector::{self, dot, square};

/// Two-sided 95 % of the normal distribution, in standard deviations.
pub const NORMAL_95: f64 = 1.959_963_984_540_054;
/// Share of a distribution below the upper end of a two-sided 95 % interval.
const UPPER_95: f64 = 0.975;
/// Median of the magnitudes of normal values, in standard deviations.
pub const MEDIAN_MAGNITUDE: f64 = 0.674_489_750_196_081_7;
/// Standard deviation of the fourth differences of white noise, in standard deviations of the noise: √70.
pub(crate) const FOURTH_DIFFERENCE_DEVIATION: f64 = 8.366_600_265_340_756;
/// Median of their magnitudes, likewise.
pub(crate) const MEDIAN_FOURTH_DIFFERENCE: f64 = MEDIAN_MAGNITUDE * FOURTH_DIFFERENCE_DEVIATION;

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

/// Smallest and largest value; infinite and the wrong way round where there are none.
#[must_use]
pub fn range<Value: Borrow<f64>>(values: impl IntoIterator<Item = Value>) -> [f64; 2] {
    let widened = |[low, high]: [f64; 2], value: Value| [low.min(*value.borrow()), high.max(*value.borrow())];
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], widened)
}

/// Probability that Student's t with `degrees_of_freedom` exceeds `score`; one where there are none.
pub(crate) fn student_above(score: f64, degrees_of_freedom: f64) -> f64 {
    StudentsT::new(0.0, 1.0, degrees_of_freedom).map_or(1.0, |student| student.sf(score))
}

/// The share of false discoveries among `p_values` up to and including one of them (Y. Benjamini, Y. Hochberg, J. R. Stat.
/// Soc. B 57, 1995, 289–300).
pub(crate) fn false_discovery_rate(p_value: f64, p_values: &[f64]) -> f64 {
    let rate = |p_value: f64| {
        let rank = p_values.iter().filter(|other| **other <= p_value).count().max(1);
        p_value * p_values.len() as f64 / rank as f64
    };
    p_values.iter().filter(|other| **other >= p_value).map(|other| rate(*other)).fold(1.0, f64::min)
}

/// Decimals that show a width, or half width, of an interval with two digits, nine at most; four where there is no width.
///
/// ```
/// assert_eq!(identification::statistics::digits(0.012), 3);
/// ```
#[must_use]
pub fn digits(width: f64) -> usize {
    if width > 0.0 { (1.0 - width.log10().floor()).clamp(0.0, 9.0) as usize } else { 4 }
}

/// A value with the half width of its interval, as people read them: with two digits of the half width.
///
/// ```
/// use identification::statistics::plus_minus;
///
/// assert_eq!(plus_minus(-0.091_634, 0.000_021), "-0.091634 ± 0.000021");
/// assert_eq!(plus_minus(1234.6, 67.8), "1235 ± 68");
/// ```
#[must_use]
pub fn plus_minus(value: f64, half_width: f64) -> String {
    let digits = digits(half_width);
    format!("{value:.digits$} ± {half_width:.digits$}")
}

/// Standard deviation of Σ `derivatives`ⱼ·valueⱼ for values with this covariance.
pub(crate) fn deviation_of_sum(covariance: &DMatrix<f64>, derivatives: &[f64]) -> f64 {
    let derivatives = DVector::from_column_slice(derivatives);
    (covariance * &derivatives).dot(&derivatives).max(0.0).sqrt()
}

/// The interval of this half width about a value.
pub(crate) fn interval(value: f64, half_width: f64) -> [f64; 2] {
    [value - half_width, value + half_width]
}

/// Half width of the interval about a value: the distance to the farther end, since a bound may cut off one end.
///
/// ```
/// assert_eq!(identification::statistics::half_width(1.0, [0.0, 3.0]), 2.0);
/// ```
#[must_use]
pub fn half_width(value: f64, [low, high]: [f64; 2]) -> f64 {
    (high - value).max(value - low)
}

/// Mean; 0 for no values.
#[must_use]
pub fn mean<V: Borrow<f64>>(values: impl IntoIterator<Item = V>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0.0), |(sum, count), value| (sum + value.borrow(), count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// The mean on the circle of angles with weights, rad.
#[must_use]
pub fn mean_angle(weighted: impl IntoIterator<Item = (f64, f64)>) -> f64 {
    let [sine, cosine] = weighted.into_iter().fold([0.0_f64; 2], |[sine, cosine], (angle_rad, weight)| {
        [sine + weight * angle_rad.sin(), cosine + weight * angle_rad.cos()]
    });
    f64::atan2(sine, cosine)
}

/// An angle moved by whole turns to within half a turn of another one, rad.
#[must_use]
pub fn nearest_turn(angle_rad: f64, to_rad: f64) -> f64 {
    angle_rad - TAU * ((angle_rad - to_rad - PI) / TAU).ceil()
}

/// Standard deviation, estimated with one degree of freedom less than there are values; not a number for a single one.
#[must_use]
pub fn standard_deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (squares / (values.len() as f64 - 1.0)).sqrt()
}

/// Mean, and its standard error as the values' scatter gives it.
pub(crate) fn mean_and_error(values: &[f64]) -> (f64, f64) {
    (mean(values), standard_deviation(values) / (values.len() as f64).sqrt())
}

/// Mean in standard errors.
pub(crate) fn mean_over_error(values: &[f64]) -> f64 {
    let (mean, error) = mean_and_error(values);
    mean / error.max(f64::MIN_POSITIVE)
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
pub fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let index = (share * (values.len() - 1) as f64).round() as usize;
    *values.select_nth_unstable_by(index, f64::total_cmp).1
}

/// A signal at `places` 0, 1, … without its straight line.
pub(crate) fn without_line(signal: &[f64], places: &[f64]) -> impl Iterator<Item = f64> {
    let count = signal.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = vector::sum(signal) / count;
    let moment = dot(places, signal) - middle * count * mean;
    let slope = moment / (count * (count * count - 1.0) / 12.0);
    signal.iter().zip(places).map(move |(value, place)| value - mean - slope * (place - middle))
}

/// What `of` makes of every value and up to `reach` neighbours on either side of it.
pub(crate) fn running(values: &[f64], reach: usize, of: impl Fn(&[f64]) -> f64) -> Vec<f64> {
    let near = |at: usize| &values[at.saturating_sub(reach)..(at + reach + 1).min(values.len())];
    (0..values.len()).map(|at| of(near(at))).collect()
}

/// The fourth difference of five neighbours: six times what the middle one differs by from the cubic through the others.
pub(crate) fn fourth_difference([first, second, middle, fourth, fifth]: &[f64; 5]) -> f64 {
    first - 4.0 * second + 6.0 * middle - 4.0 * fourth + fifth
}

/// Standard deviation of the white noise in a signal, from its fourth differences, in which motion hardly shows.
pub(crate) fn noise_deviation(signal: &[f64]) -> f64 {
    let mut fourth: Vec<f64> = signal.array_windows().map(|around| fourth_difference(around).abs()).collect();
    median(&mut fourth) / MEDIAN_FOURTH_DIFFERENCE
}

/// All runs of neighbours that are alike.
pub(crate) fn runs<T>(values: &[T], alike: impl FnMut(&T, &T) -> bool) -> impl Iterator<Item = Range<usize>> {
    values.chunk_by(alike).scan(0, |start, run| {
        *start += run.len();
        Some(*start - run.len()..*start)
    })
}

/// Root of the mean square; 0 for no values.
#[must_use]
pub fn rms(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    (square(values) / count).sqrt()
}

/// Correlation of the ranks of pairs (Spearman's), equal values sharing a rank; zero for fewer than three pairs, or if all are equal.
pub(crate) fn rank_correlation(pairs: &[[f64; 2]]) -> f64 {
    let ranks = |of: usize| {
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| pairs[*a][of].total_cmp(&pairs[*b][of]));
        let middle = 0.5 * (pairs.len() as f64 - 1.0);
        let mut ranks = vec![0.0; pairs.len()];
        for run in runs(&order, |one, other| pairs[*one][of] == pairs[*other][of]) {
            let shared = 0.5 * (run.start + run.end - 1) as f64 - middle;
            order[run].iter().for_each(|index| ranks[*index] = shared);
        }
        ranks
    };
    if pairs.len() < 3 {
        return 0.0;
    }
    let (left, right) = (ranks(0), ranks(1));
    let size = (square(&left) * square(&right)).sqrt();
    if size > 0.0 { dot(&left, &right) / size } else { 0.0 }
}
