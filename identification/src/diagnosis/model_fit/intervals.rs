//! 95 % intervals of a structure's parameters, whatever its form.

use std::collections::BTreeMap;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::Value;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::structure::Structure;
use crate::regression::least_squares::{LeastSquares, RobustCovariance};
use crate::uncertainty::statistics::student_95;

/// Values with intervals of each effect of a structure that was fitted to a capture.
///
/// The torque's derivatives by all values are the columns of a linear problem in small changes; its covariance
/// allows for correlated residuals.
pub(crate) fn of(structure: &Structure, capture: &Capture) -> Vec<BTreeMap<&'static str, Value>> {
    let fit = Nonlinear::new(structure.clone(), capture);
    let intervals = Intervals::new(&fit, &fit.secants());
    values(structure, &intervals)
}

/// The same for the values with a straight end as they are. Of a drift that may as well be a straight line only the slope is known: neither how far
/// it goes nor for how long has a useful interval, though the drift is surely something.
pub(crate) fn given_straight_ends(structure: &Structure, capture: &Capture) -> Vec<BTreeMap<&'static str, Value>> {
    let fit = Nonlinear::new(structure.clone(), capture);
    let mut tangents = fit.secants();
    fit.with_straight_end().for_each(|column| tangents[column].fill(0.0));
    values(structure, &Intervals::new(&fit, &tangents))
}

fn values(structure: &Structure, intervals: &Intervals<'_, '_>) -> Vec<BTreeMap<&'static str, Value>> {
    let mut effects = Vec::new();
    for (index, effect) in structure.effects.iter().enumerate() {
        let mut values = BTreeMap::new();
        for (parameter, kind) in effect.kind().parameters.iter().enumerate() {
            let value = effect.values()[parameter];
            let column = intervals.fit.column_of(index, parameter);
            let ci95 = column.and_then(|column| intervals.of(column));
            if column.is_some() || value != 0.0 {
                values.insert(kind.name, Value { value, unit: kind.unit, ci95 });
            }
        }
        effects.push(values);
    }
    effects
}

/// The linear problem in small changes of the values.
struct Intervals<'a, 'b> {
    fit: &'a Nonlinear<'b>,
    solved: LeastSquares,
    robust: RobustCovariance,
}

impl<'a, 'b> Intervals<'a, 'b> {
    fn new(fit: &'a Nonlinear<'b>, tangents: &[Vec<f64>]) -> Self {
        let solved = LeastSquares::solve(tangents, &fit.residual);
        let robust = solved.robust(tangents);
        Self { fit, solved, robust }
    }

    /// The interval of a value; `None` if it is not identifiable.
    fn of(&self, column: usize) -> Option<[f64; 2]> {
        if self.solved.collinear[column] {
            return None;
        }
        // Where a search ended early, the step that is left belongs into the interval.
        let by_chance = student_95(self.robust.degrees_of_freedom) * self.robust.matrix[(column, column)].sqrt();
        let half = by_chance + self.solved.coefficients[column].abs();
        self.fit.interval(column, half).filter(|[low, high]| low.is_finite() && high.is_finite())
    }
}
