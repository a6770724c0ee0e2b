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
    let tangents = fit.secants();
    let solved = LeastSquares::solve(&tangents, &fit.residual);
    let RobustCovariance { matrix: covariance, degrees_of_freedom, .. } = solved.robust(&tangents);
    let critical = student_95(degrees_of_freedom);
    let mut all = Vec::new();
    for (index, effect) in structure.effects.iter().enumerate() {
        let mut values = BTreeMap::new();
        for (parameter, kind) in effect.kind().parameters.iter().enumerate() {
            let value = effect.values()[parameter];
            let column = fit.column_of(index, parameter);
            let ci95 = column.filter(|column| !solved.collinear[*column]).and_then(|column| {
                // Where a search ended early, the step that is left belongs into the interval.
                let half = critical * covariance[(column, column)].sqrt() + solved.coefficients[column].abs();
                fit.interval(column, value, half).filter(|[low, high]| low.is_finite() && high.is_finite())
            });
            if column.is_some() || value != 0.0 {
                values.insert(kind.name, Value { value, unit: kind.unit, ci95 });
            }
        }
        all.push(values);
    }
    all
}
