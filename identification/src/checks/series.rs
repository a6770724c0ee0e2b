//! Bins in a row: holes bridged, shocks and slopes taken out.

use crate::uncertainty::statistics::{mean, median};

/// Bins over which the torque's median is taken, so that single shocks do not count.
const MEDIAN_OF: usize = 5;
/// Bins over which the torque is averaged before it is counted.
const SMOOTHED: usize = 3;
/// Longest hole in the passed angles that is bridged, bins: 2°.
const LONGEST_BRIDGE: usize = 8;

/// The values with short holes bridged by straight lines: missed ticks and slips leave such.
#[allow(clippy::cast_precision_loss, reason = "a few bins")]
pub(super) fn bridged(values: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut bridged = values.to_vec();
    let mut before: Option<(usize, f64)> = None;
    for (index, value) in values.iter().enumerate() {
        let Some(value) = *value else { continue };
        if let Some((from, start)) = before
            && index - from <= LONGEST_BRIDGE
        {
            let slope = (value - start) / (index - from) as f64;
            (from + 1..index).for_each(|at| bridged[at] = Some(start + slope * (at - from) as f64));
        }
        before = Some((index, value));
    }
    bridged
}

/// Start and length of the longest run of `true`.
pub(super) fn longest_run(values: &[bool]) -> (usize, usize) {
    let (mut best, mut start) = ((0, 0), 0);
    for index in 0..=values.len() {
        if values.get(index) != Some(&true) {
            if index - start > best.1 {
                best = (start, index - start);
            }
            start = index + 1;
        }
    }
    best
}

/// The running median.
pub(super) fn without_shocks(signal: &[f64]) -> Vec<f64> {
    let last = signal.len().saturating_sub(1);
    (0..signal.len())
        .map(|index| {
            median(&mut signal[index.saturating_sub(MEDIAN_OF / 2)..=(index + MEDIAN_OF / 2).min(last)].to_vec())
        })
        .collect()
}

/// The running mean.
pub(super) fn smoothed(signal: &[f64]) -> Vec<f64> {
    let last = signal.len().saturating_sub(1);
    (0..signal.len())
        .map(|index| mean(&signal[index.saturating_sub(SMOOTHED / 2)..=(index + SMOOTHED / 2).min(last)]))
        .collect()
}

/// The signal without its straight line.
#[allow(clippy::cast_precision_loss, reason = "bins of some turns")]
pub(super) fn centred(signal: &[f64]) -> Vec<f64> {
    let count = signal.len().max(1) as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = mean(signal);
    let moment: f64 = signal.iter().enumerate().map(|(at, value)| (at as f64 - middle) * (value - mean)).sum();
    let spread: f64 = (0..signal.len()).map(|at| (at as f64 - middle).powi(2)).sum();
    let slope = moment / spread.max(f64::MIN_POSITIVE);
    signal.iter().enumerate().map(|(at, value)| value - mean - slope * (at as f64 - middle)).collect()
}
