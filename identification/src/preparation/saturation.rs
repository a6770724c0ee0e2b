//! Stretches where a channel was saturated, or an encoder frozen while the knob turned.

use std::ops::Range;

use crate::numerics::statistics::{rms, runs};
use crate::numerics::vector;

/// Shortest run of equal values at an end of the range that may be saturation, samples.
const SHORTEST: usize = 5;
/// A saturated channel's longest run is this many times as long as its longest run of equal values within the range, which
/// noise, steps and rests make.
const BEYOND_WITHIN: usize = 3;
/// Shortest run of one angle that may be a frozen encoder, samples.
const SHORTEST_FROZEN: usize = 20;
/// An encoder froze if the angle jumps afterwards by this many times its largest step nearby.
const JUMP: f64 = 10.0;
/// … and by more than this many steps of the encoder: a coarse encoder that works jumps by one step at a time.
const MORE_THAN_A_STEP: f64 = 1.5;
/// Steps on either side of a run that tell how fast the knob was.
const NEARBY: usize = 10;

/// Where a channel reads its largest or smallest value for longer than noise explains: its rails.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Saturation {
    pub(crate) runs: Vec<Range<usize>>,
    /// Smallest and largest value, where they are rails.
    low: Option<f64>,
    high: Option<f64>,
}

impl Saturation {
    pub(crate) fn of(values: &[f64]) -> Self {
        let runs = runs_of_equal(values);
        let Some((low, high)) = vector::extent(values) else { return Self::default() };
        let is_end = |value: f64| value == low || value == high;
        let within = runs.iter().filter(|run| !is_end(values[run.start])).map(ExactSizeIterator::len).max();
        let least = SHORTEST.max(BEYOND_WITHIN * within.unwrap_or(1));
        // A channel that only knows two values has no range between them.
        let has_range = values.iter().any(|value| !is_end(*value));
        let is_rail = |end: &f64| has_range && runs.iter().any(|run| values[run.start] == *end && run.len() >= least);
        let (low, high) = (Some(low).filter(is_rail), Some(high).filter(is_rail));
        // Shorter runs at a rail are no measurements either.
        let runs = runs.into_iter().filter(|run| [low, high].contains(&Some(values[run.start]))).collect();
        Self { runs, low, high }
    }

    /// Number of samples at a rail.
    pub(crate) fn samples(&self) -> usize {
        self.runs.iter().map(ExactSizeIterator::len).sum()
    }

    /// Whether a sample is at a rail.
    pub(crate) fn contains(&self, index: usize) -> bool {
        let after = self.runs.partition_point(|run| run.start <= index);
        after > 0 && self.runs[after - 1].contains(&index)
    }

    /// A sentence on it, if there is a rail.
    pub(crate) fn note(&self, channel: &str, unit: &str) -> Option<String> {
        let ends = match (self.low, self.high) {
            (Some(low), Some(high)) => format!("both ends of its range, {low} and {high} {unit},"),
            (Some(end), None) => format!("the lower end of its range, {end} {unit},"),
            (None, Some(end)) => format!("the upper end of its range, {end} {unit},"),
            (None, None) => return None,
        };
        Some(format!(
            "the {channel} channel stands at {ends} for {} samples (stretches: {}), which the fit leaves out: excite the \
             knob less, or use a sensor with a wider range",
            self.samples(),
            self.runs.len()
        ))
    }
}

/// Stretches where the encoder stood still while the knob turned on: the angle stands still and then jumps.
pub(crate) fn frozen(angle_rad: &[f64], torque_mnm: &[f64]) -> Vec<Range<usize>> {
    let mut runs = runs_of_equal(angle_rad);
    runs.retain(|run| run.len() >= SHORTEST_FROZEN);
    if runs.is_empty() {
        return runs;
    }
    let steps: Vec<f64> = angle_rad.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let typical = rms(&steps);
    let resolution = vector::smallest_step(angle_rad);
    let largest = |range: Range<usize>| steps[range].iter().map(|step| step.abs()).fold(0.0, f64::max);
    runs.retain(|run| {
        let torque = &torque_mnm[run.clone()];
        if torque.iter().all(|value| *value == torque[0]) {
            return false;
        }
        // steps[n] leads from sample n to sample n + 1, so that steps[run.end − 1] leads out of the run.
        let before = run.start.saturating_sub(NEARBY + 1)..run.start.saturating_sub(1);
        let after = run.end.min(steps.len())..(run.end + NEARBY).min(steps.len());
        let out = steps.get(run.end - 1).map_or(0.0, |step| step.abs());
        out > MORE_THAN_A_STEP * resolution && out > JUMP * largest(before).max(largest(after)).max(typical / JUMP)
    });
    runs
}

/// A sentence on a frozen encoder.
pub(crate) fn frozen_note(runs: &[Range<usize>]) -> Option<String> {
    let samples: usize = runs.iter().map(ExactSizeIterator::len).sum();
    (samples > 0).then(|| {
        format!(
            "the angle stands still for {samples} samples (stretches: {}) and then jumps, while the torque moves: the encoder \
             missed the motion, and the fit leaves them out; check the encoder and its cable",
            runs.len()
        )
    })
}

/// All runs of two or more equal values.
fn runs_of_equal(values: &[f64]) -> Vec<Range<usize>> {
    runs(values, |value, next| value == next).filter(|run| run.len() > 1).collect()
}

#[cfg(test)]
mod tests {
    use super::frozen;

    #[test]
    fn a_coarse_encoder_that_goes_on_by_one_step_is_not_frozen() {
        let turning = |n: u32| (f64::from(n) * 1e-3).sin();
        let torque: Vec<f64> = (0..10_000).map(|n| f64::from(n % 7)).collect();
        for step_rad in [1e-4, 1e-2, 1e-1] {
            let coarse: Vec<f64> = (0..10_000).map(|n| (turning(n) / step_rad).round() * step_rad).collect();
            assert!(frozen(&coarse, &torque).is_empty(), "steps of {step_rad} rad");
        }
        let stuck: Vec<f64> = (0..10_000)
            .map(|n| (turning(if (3000..3100).contains(&n) { 3000 } else { n }) / 1e-4).round() * 1e-4)
            .collect();
        assert_eq!(frozen(&stuck, &torque).len(), 1);
    }
}
