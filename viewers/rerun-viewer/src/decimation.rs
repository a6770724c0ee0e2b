//! Reduces a stream to what a screen can show without hiding an extreme.
//!
//! Time is cut into bins as wide as a pixel or so; of each bin the smallest and the largest value
//! stay, at the times at which they were measured. A spike of one sample is therefore seen.

use crate::frame::Points;

/// What stays of a bin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keep {
    MinMax,
    Max,
}

#[derive(Clone, Debug)]
pub struct Decimator {
    keep: Keep,
    bin_ns: i64,
    open: Option<Bin>,
    done: Points,
}

#[derive(Clone, Copy, Debug)]
struct Bin {
    index: i64,
    min: (i64, f64),
    max: (i64, f64),
}

impl Decimator {
    /// A decimator whose bins are `bin_ns` wide, at least 1 ns.
    pub fn new(keep: Keep, bin_ns: i64) -> Self {
        Self { keep, bin_ns: bin_ns.max(1), open: None, done: Points::default() }
    }

    /// Takes in a value; values that are not numbers leave no trace.
    pub fn push(&mut self, time_ns: i64, value: f64) {
        if !value.is_finite() {
            return;
        }
        let index = time_ns.div_euclid(self.bin_ns);
        match &mut self.open {
            Some(bin) if bin.index == index => {
                bin.min = if value < bin.min.1 { (time_ns, value) } else { bin.min };
                bin.max = if value > bin.max.1 { (time_ns, value) } else { bin.max };
            }
            _ => {
                self.close_bin();
                self.open = Some(Bin { index, min: (time_ns, value), max: (time_ns, value) });
            }
        }
    }

    /// The points of the bins that are complete, each handed out once.
    pub fn take(&mut self) -> Points {
        std::mem::take(&mut self.done)
    }

    /// Completes the open bin, for a stream that has ended.
    pub fn close_bin(&mut self) {
        let Some(Bin { min, max, .. }) = self.open.take() else { return };
        let mut keep = |(time_ns, value)| self.done.push(time_ns, &[value]);
        match self.keep {
            Keep::Max => keep(max),
            Keep::MinMax if min.0 == max.0 => keep(min),
            Keep::MinMax if min.0 < max.0 => [min, max].into_iter().for_each(keep),
            Keep::MinMax => [max, min].into_iter().for_each(keep),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decimated(keep: Keep, bin_ns: i64, samples: impl IntoIterator<Item = (i64, f64)>) -> Points {
        let mut decimator = Decimator::new(keep, bin_ns);
        samples.into_iter().for_each(|(time_ns, value)| decimator.push(time_ns, value));
        decimator.close_bin();
        decimator.take()
    }

    #[test]
    fn a_spike_of_one_sample_keeps_its_height_and_its_time() {
        let value = |tick: i64| if tick == 77 { 1_000.0 } else { (tick as f64 * 0.1).sin() };
        let points = decimated(Keep::MinMax, 4_000_000, (0..200).map(|tick| (tick * 100_000, value(tick))));
        let spike = points.values.iter().position(|&value| value == 1_000.0);
        assert_eq!(spike.map(|at| points.times_ns[at]), Some(7_700_000));
    }

    #[test]
    fn ten_thousand_samples_a_second_become_five_hundred_in_order() {
        let samples = (0..10_000_i64).map(|tick| (tick * 100_000, ((tick * 7919) % 1013) as f64));
        let points = decimated(Keep::MinMax, 4_000_000, samples);
        assert_eq!(points.values.len(), 500);
        assert!(points.times_ns.is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn a_bin_with_one_value_gives_one_point_once_it_is_complete() {
        let mut decimator = Decimator::new(Keep::MinMax, 1_000);
        decimator.push(0, 2.0);
        decimator.push(5_000, 3.0);
        assert_eq!(decimator.take(), Points { times_ns: vec![0], values: vec![2.0] });
        assert_eq!(decimator.take(), Points::default());
    }

    #[test]
    fn the_longest_lateness_of_a_bin_stays() {
        let points = decimated(Keep::Max, 1_000, [(0, 5.0), (10, 9.0), (20, f64::NAN), (30, 1.0)]);
        assert_eq!(points, Points { times_ns: vec![10], values: vec![9.0] });
    }
}
