//! The smallest and largest value of a signal over the last seconds.

use std::collections::VecDeque;

/// Extremes over a window that moves on in steps; bounded by the number of steps.
#[derive(Clone, Debug)]
pub struct Extremes {
    steps: VecDeque<(f64, f64)>,
    kept: usize,
}

impl Extremes {
    /// A window of `kept` steps, at least one.
    pub fn new(kept: usize) -> Self {
        Self { steps: VecDeque::from([EMPTY]), kept: kept.max(1) }
    }

    /// Takes in a value; one that is not a number leaves no trace.
    pub fn push(&mut self, value: f64) {
        if let (Some((low, high)), true) = (self.steps.back_mut(), value.is_finite()) {
            *low = low.min(value);
            *high = high.max(value);
        }
    }

    /// Moves the window on by one step.
    pub fn step(&mut self) {
        if self.steps.len() >= self.kept {
            self.steps.pop_front();
        }
        self.steps.push_back(EMPTY);
    }

    /// Smallest and largest value in the window; `None` while it is empty.
    pub fn range(&self) -> Option<(f64, f64)> {
        let join = |(low, high): (f64, f64), step: &(f64, f64)| (low.min(step.0), high.max(step.1));
        let (low, high) = self.steps.iter().fold(EMPTY, join);
        (low <= high).then_some((low, high))
    }
}

/// The range of no values.
const EMPTY: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_extreme_is_forgotten_once_the_window_has_passed_it() {
        let mut extremes = Extremes::new(2);
        extremes.push(50.0);
        extremes.step();
        extremes.push(-1.0);
        extremes.push(f64::NAN);
        assert_eq!(extremes.range(), Some((-1.0, 50.0)));
        extremes.step();
        extremes.push(2.0);
        assert_eq!(extremes.range(), Some((-1.0, 2.0)));
    }

    #[test]
    fn there_are_no_extremes_before_there_are_values() {
        assert_eq!(Extremes::new(3).range(), None);
    }
}
