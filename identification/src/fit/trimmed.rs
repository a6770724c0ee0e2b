//! The settled problem: effects, searched parameters and a small delay of the torque channel, fitted together.

use dynamics::{Effect, Part};

use crate::preparation::band::Band;
use crate::preparation::row_filter::RowFilter;
use crate::regression::characteristic::CurveProjection;
use crate::regression::gram::Correction;
use crate::regression::least_squares::LeastSquares;
use crate::regression::problem::{Column, Problem};

/// A delay between torque and motion is believed only up to this many samples; more is an effect of its own.
const LARGEST_DELAY_SAMPLES: f64 = 0.5;
/// Standard errors by which a delay must differ from zero to be allowed for.
const DELAY_SIGNIFICANCE: f64 = 4.5;

/// A problem with everything settled: effects, searched parameters and the delay.
pub(crate) struct Trimmed<'a> {
    pub(crate) problem: Problem<'a>,
    /// All columns: the effects' linear ones, then those of searched parameters, then that of the delay if it is fitted.
    pub(crate) columns: Vec<Column>,
    /// The target of the fit: the problem's target, its part beyond measured curves projected off their points.
    pub(crate) target: Column,
    pub(crate) solution: LeastSquares,
    /// Measured curves off which the columns have been projected.
    pub(crate) curves: Option<CurveProjection>,
    /// Delay of the torque behind the motion that was allowed for, s.
    pub(crate) delay_s: f64,
    /// A delay that was not allowed for.
    pub(crate) delay: Option<OmittedDelay>,
}

/// A delay that was not fitted, because it is too long for a trim or not significant.
pub(crate) struct OmittedDelay {
    pub(super) delay_s: f64,
    /// Its column, per second of delay.
    pub(super) column: Column,
}

/// Rows of torque and of every column.
pub(crate) struct Rows {
    pub(crate) columns: Vec<Column>,
    pub(crate) target: Column,
}

impl<'a> Trimmed<'a> {
    /// The problem solved together with further columns, without a delay.
    fn with(problem: Problem<'a>, further: &[Column]) -> Self {
        let (columns, solution) = problem.solve_with(further);
        Self { target: problem.target.clone(), problem, columns, solution, curves: None, delay_s: 0.0, delay: None }
    }

    /// The sum of these rows and the rows of further samples, which only the row filter `other` keeps.
    pub(super) fn with_rows_of(&self, other: &RowFilter, band: &Band, torque_mnm: &[f64]) -> Rows {
        let coefficients = &self.solution.coefficients;
        let problem = Problem::new(other, self.problem.motion, band, torque_mnm, &self.problem.effects);
        let mut columns = problem.columns.clone();
        columns.extend(problem.tangents(coefficients));
        let mut target = problem.target.to_vec();
        if columns.len() < self.columns.len() {
            let delay = problem.delay_column(coefficients);
            target.iter_mut().zip(&*delay).for_each(|(torque, value)| *torque -= self.delay_s * value);
            columns.push(delay);
        }
        let sum = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one + other).collect();
        Rows {
            columns: self.columns.iter().zip(&columns).map(|(one, other)| sum(one, other)).collect(),
            target: sum(&self.problem.target, &target),
        }
    }

    /// Solves again with the other columns projected off the points of measured curves: the curves keep their torques, and their uncertainty
    /// enters that of the other parameters.
    pub(super) fn project_curves_out(&mut self, curves: CurveProjection) {
        let Self { problem, columns, target, .. } = self;
        let less = |column: &[f64], part: &[f64]| -> Vec<f64> {
            column.iter().zip(part).map(|(value, part)| value - part).collect()
        };
        let done = |column: &[f64]| less(column, &curves.remainder(column));
        let is_curve = |effect: &Effect| matches!(effect.kind().part, Part::TorqueTable(_) | Part::FrictionTable(_));
        let effects = (0..problem.effects.len()).filter(|effect| is_curve(&problem.effects[*effect]));
        let of_curves: Vec<usize> = effects.flat_map(|effect| problem.range(effect)).collect();
        // The mean torque of both directions belongs to the curves: beside them only the mean of the two Coulomb frictions is estimated.
        let coulomb = problem.both_ways().map(|(places, both)| {
            let half: Vec<f64> = done(&both).into_iter().map(|value| 0.5 * value).collect();
            (places, half)
        });
        let mut beyond = problem.target.to_vec();
        for (index, place) in columns.iter_mut().enumerate() {
            let column = place.clone();
            let part = match &coulomb {
                _ if of_curves.contains(&index) => {
                    beyond = less(&beyond, &column);
                    curves.remainder(&column)
                }
                Some((places, half)) if places.contains(&index) => half.clone(),
                _ => done(&column),
            };
            *place = less(&column, &part).into();
        }
        beyond = curves.remainder(&beyond);
        for index in of_curves {
            beyond.iter_mut().zip(&*columns[index]).for_each(|(sum, value)| *sum += value);
        }
        *target = beyond.into();
        let mut nonnegative = problem.nonnegative.clone();
        nonnegative.resize(columns.len(), false);
        let share = 1.0 - curves.points.len() as f64 / target.len() as f64;
        let noise = problem.column_noise().into_iter();
        let noise: Vec<Correction> = noise
            .map(|noise| Correction { square: share * noise.square, product: share * noise.product, ..noise })
            .collect();
        self.solution = LeastSquares::corrected(columns, target, &nonnegative, &noise);
        self.curves = Some(curves);
    }

    /// The effects with all their values filled in.
    pub(crate) fn effects(&self) -> Vec<Effect> {
        let mut effects = self.problem.effects.clone();
        for (index, effect) in effects.iter_mut().enumerate() {
            if let Some(regressors) = effect.kind().regressors {
                (regressors.values)(&self.solution.coefficients[self.problem.range(index)], effect.values_mut());
            }
        }
        effects
    }
}

/// Fits a small delay of the torque channel, if the data show one, together with everything else.
pub(super) fn trim<'a>(problem: Problem<'a>, solution: &LeastSquares) -> Trimmed<'a> {
    let tangents_alone = problem.tangents(&solution.coefficients);
    let mut with_delay = tangents_alone.clone();
    with_delay.push(problem.delay_column(&solution.coefficients));
    let (columns, extended) = problem.solve_with(&with_delay);
    let delay_index = columns.len() - 1;
    let delay_s = extended.coefficients[delay_index];
    let significant = delay_s.abs() > DELAY_SIGNIFICANCE * extended.robust_deviation(&columns, delay_index)
        && extended.squares() < (1.0 - 1e-6) * solution.squares();
    let small = delay_s.abs() <= LARGEST_DELAY_SAMPLES / problem.row_filter.rate_hz;
    if significant && small {
        // The delay shifts the searched parameters too: the column takes it out, then they settle again.
        let mut problem = problem;
        let delay_rows = columns[delay_index].clone();
        problem.target =
            problem.target.iter().zip(&*delay_rows).map(|(torque, value)| torque - delay_s * value).collect();
        let settled = problem.refine(4, |_, value| 0.01 * value.abs());
        let mut further = problem.tangents(&settled.coefficients);
        further.push(delay_rows);
        return Trimmed { delay_s, ..Trimmed::with(problem, &further) };
    }
    let omitted = OmittedDelay { delay_s, column: columns[delay_index].clone() };
    Trimmed { delay: Some(omitted), ..Trimmed::with(problem, &tangents_alone) }
}

/// The problem as it is, without a delay.
pub(super) fn untrimmed(problem: Problem<'_>) -> Trimmed<'_> {
    let tangents = problem.tangents(&problem.solve().coefficients);
    Trimmed::with(problem, &tangents)
}
