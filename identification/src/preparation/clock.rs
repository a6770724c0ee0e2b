//! The times of samples: their typical step, and values between them.

use crate::numerics::interpolation::cubic_weights;
use crate::numerics::statistics::median;

/// Scatter of the sample period, relative to its mean, from which a capture is interpolated onto an even grid.
pub(super) const JITTER: f64 = 0.01;
/// A step of time longer than this many sample periods is a gap: samples were lost.
pub(super) const GAP: f64 = 1.5;

/// A column's value between the sample at `index` and the next: on the cubic through these two and the nearest samples at least half a
/// period beyond either, or on the straight line between the two where a gap or an end is too near for the cubic.
pub(super) fn between(time: &[f64], column: &[f64], index: usize, at: f64, step: f64) -> f64 {
    let is_near = |one: usize, other: usize| time[other] - time[one] <= GAP * step;
    let before = (0..index).rev().find(|other| time[index] - time[*other] >= 0.5 * step);
    let after = (index + 2..time.len()).find(|other| time[*other] - time[index + 1] >= 0.5 * step);
    if let (Some(before), Some(after)) = (before, after)
        && is_near(before, index)
        && is_near(index, index + 1)
        && is_near(index + 1, after)
    {
        let places = [before, index, index + 1, after];
        let weights = cubic_weights(places.map(|place| time[place] - at), 0.0);
        return weights.iter().zip(places).map(|(weight, place)| weight * column[place]).sum();
    }
    let share = (at - time[index]) / (time[index + 1] - time[index]);
    column[index] + share * (column[index + 1] - column[index])
}

/// The sample period, s: the mean step where all steps are alike, else their median; and whether they are alike.
pub(crate) fn typical_step(time: &[f64]) -> (f64, bool) {
    let mean = (time[time.len() - 1] - time[0]) / (time.len() - 1) as f64;
    let farthest = time.iter().zip(&time[1..]).map(|(left, right)| (right - left - mean).abs()).fold(0.0, f64::max);
    if farthest < JITTER * mean {
        return (rounded(mean), true);
    }
    let mut steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    (rounded(median(&mut steps)), false)
}

/// The step with its rate rounded to twelve digits, the precision of differences of a file's times.
pub(super) fn rounded(step_s: f64) -> f64 {
    let rate_hz = 1.0 / step_s;
    let unit = 10.0_f64.powf(rate_hz.log10().floor() - 11.0);
    1.0 / ((rate_hz / unit).round() * unit)
}

/// The whole part of a number of samples; a number that only rounding puts just below a whole one counts as that one.
pub(crate) fn whole(samples: f64) -> usize {
    (samples * (1.0 + 1e-9)) as usize
}
