//! 95 % intervals of a structure's parameters, whatever its form.

use std::collections::BTreeMap;

use dynamics::Effect;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::Value;
use crate::diagnosis::model_fit::nonlinear::Nonlinear;
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::statistics::student_95;
use crate::regression::least_squares::LeastSquares;

/// Values with intervals of each effect of a structure that was fitted to a capture.
///
/// The torque's derivatives by all values are the columns of a linear problem in small changes; its covariance
/// allows for correlated residuals.
pub(crate) fn of(structure: &Structure, capture: &Capture) -> Vec<BTreeMap<&'static str, Value>> {
    let fit = Nonlinear::new(structure.clone(), capture);
    values(&fit, &fit.secants(), &fit.residual)
}

/// As [`of`], but with the values that have a straight end held fixed. If a drift may as well be a straight line, only its slope is known: neither
/// its extent nor its duration has a useful interval, though the drift is certain.
pub(crate) fn given_straight_ends(structure: &Structure, capture: &Capture) -> Vec<BTreeMap<&'static str, Value>> {
    let fit = Nonlinear::new(structure.clone(), capture);
    given_straight_ends_of(&fit, fit.secants(), &fit.residual)
}

/// As [`given_straight_ends`], from the derivatives and the residual in other rows than the fit's own.
pub(crate) fn given_straight_ends_of(
    fit: &Nonlinear<'_>,
    mut tangents: Vec<Vec<f64>>,
    residual: &[f64],
) -> Vec<BTreeMap<&'static str, Value>> {
    fit.with_straight_end().for_each(|column| tangents[column].fill(0.0));
    values(fit, &tangents, residual)
}

fn values(fit: &Nonlinear<'_>, tangents: &[Vec<f64>], residual: &[f64]) -> Vec<BTreeMap<&'static str, Value>> {
    let solved = LeastSquares::solve(tangents, residual);
    let robust = solved.robust(tangents);
    let interval = |column: usize| {
        // If a search ended early, the interval includes the step that it still had to take.
        let by_chance = student_95(robust.degrees_of_freedom) * robust.matrix[(column, column)].sqrt();
        let ci95 = fit.interval(column, by_chance + solved.coefficients[column].abs());
        ci95.filter(|[low, high]| !solved.collinear[column] && low.is_finite() && high.is_finite())
    };
    let of_effect = |(index, effect): (usize, &Effect)| {
        let parameters = effect.kind().parameters.iter().zip(effect.values()).enumerate();
        let values = parameters.filter_map(|(parameter, (kind, value))| {
            let column = fit.column_of(index, parameter);
            let value = Value { value: *value, unit: kind.unit, ci95: column.and_then(interval) };
            (column.is_some() || value.value != 0.0).then_some((kind.name, value))
        });
        values.collect()
    };
    fit.structure.effects.iter().enumerate().map(of_effect).collect()
}
