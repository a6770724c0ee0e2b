//! Several readings of one quantity: their mean and its interval.

use dynamics::{Minimum, ParameterKind};

use crate::estimate::Parameter;
use crate::uncertainty::statistics::{NORMAL_95, mean, mean_and_error, student_95};

use super::slide::to_f64;

/// Fewest readings from which a value is given.
pub(super) const FEWEST: usize = 3;

/// Readings of one quantity.
#[derive(Clone, Debug, Default)]
pub(super) struct Readings {
    values: Vec<f64>,
    /// The same read in another way.
    others: Vec<f64>,
}

impl Readings {
    pub(super) fn push(&mut self, value: f64, other: f64) {
        self.values.push(value);
        self.others.push(other);
    }

    pub(super) fn count(&self) -> usize {
        self.values.len()
    }

    /// Mean and interval; `why` says why there is none.
    ///
    /// The readings' scatter counts with Student's quantile. What the way of reading does to all of them alike the mean
    /// does not take off: the means of both ways differ by it, and it counts as an error anywhere between plus and
    /// minus that difference, whose standard deviation is a √3-th of it (Guide to the Expression of Uncertainty in
    /// Measurement, 4.3.7). The textbook's interval is the scatter alone.
    pub(super) fn parameter(&self, kind: &ParameterKind, why: impl FnOnce() -> String) -> Parameter {
        if self.count() < FEWEST {
            return Parameter::not_identifiable(kind.name, kind.unit, why());
        }
        let count = to_f64(self.count());
        let (value, standard_error) = mean_and_error(&self.values);
        let scatter = student_95(count - 1.0) * standard_error;
        let difference = mean(&self.others) - value;
        let half = scatter.hypot(NORMAL_95 * difference / 3.0_f64.sqrt());
        let lowest = if kind.minimum == Minimum::None { f64::NEG_INFINITY } else { 0.0 };
        let interval = |half: f64| [(value - half).max(lowest), value + half];
        Parameter {
            name: kind.name,
            value: Some(value.max(lowest)),
            unit: kind.unit,
            ci95: Some(interval(half)),
            ci95_textbook: Some(interval(scatter)),
            reason: None,
        }
    }
}
