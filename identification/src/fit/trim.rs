//! The torque's delay: fitted together with everything else where the data show a small one.

use dynamics::Effect;

use crate::regression::{Column, LeastSquares, Problem};

/// A delay between torque and motion is believed only up to this many samples; more is an effect of its own.
const LARGEST_DELAY_SAMPLES: f64 = 0.5;
/// Standard errors by which a delay must differ from zero to be allowed for.
const DELAY_SIGNIFICANCE: f64 = 4.5;

/// A delay too long for a trim is noted if it explains this share of the residual's sum of squares.
const WORTH_A_NOTE: f64 = 0.25;

/// A problem with everything settled: effects, searched parameters and the delay.
pub(super) struct Trimmed<'a> {
    pub(super) problem: Problem<'a>,
    /// All columns: the effects' linear ones, then those of searched parameters, then that of the delay if it is fitted.
    pub(super) columns: Vec<Column>,
    pub(super) solution: LeastSquares,
    /// What the residual was made orthogonal to, if not the columns themselves.
    pub(super) instruments: Option<Vec<Column>>,
    /// Delay of the torque behind the motion that was allowed for, s.
    pub(super) delay_s: f64,
    /// Delay that the data ask for although it is too long for a trim, s.
    pub(super) refused_delay_s: Option<f64>,
}

impl Trimmed<'_> {
    /// Solves again with another sensor's acceleration as the instrument for the inertia.
    pub(super) fn instrument(&mut self, acceleration_rad_s2: &[f64]) {
        let instruments = self.problem.instruments(&self.columns, acceleration_rad_s2);
        self.solution = self.solution.clone().instrumented(&self.columns, &instruments, &self.problem.target);
        self.instruments = Some(instruments);
    }

    /// A sentence on a delay that was refused.
    pub(super) fn note(&self) -> Option<String> {
        self.refused_delay_s.map(|delay_s| {
            format!(
                "the torque seems to come {:.2} ms {} the motion, more than half a sample: calibrate the delay or diagnose the \
                 capture",
                1e3 * delay_s.abs(),
                if delay_s > 0.0 { "after" } else { "before" }
            )
        })
    }

    /// The effects with all their values filled in.
    pub(super) fn effects(&self) -> Vec<Effect> {
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
    let tangents = problem.tangents(&solution.coefficients);
    let mut with_delay = tangents.clone();
    with_delay.push(problem.delay_column(&solution.coefficients));
    let (columns, extended) = problem.solve_with(&with_delay);
    let delay_index = columns.len() - 1;
    let delay_s = extended.coefficients[delay_index];
    let significant = delay_s.abs() > DELAY_SIGNIFICANCE * extended.robust_deviation(&columns, delay_index)
        && extended.improves(solution);
    let worthwhile = extended.squares() < (1.0 - WORTH_A_NOTE) * solution.squares();
    let small = delay_s.abs() <= LARGEST_DELAY_SAMPLES / problem.row_mask.rate_hz;
    if significant && small {
        // The delay shifts the searched parameters too: the column takes it out, then they settle again.
        let mut problem = problem;
        let delay_rows = columns[delay_index].clone();
        let target = problem.target.iter().zip(&*delay_rows).map(|(torque, value)| torque - delay_s * value);
        problem.set_target(target.collect());
        let settled = problem.refine(4, |_, value| 0.01 * value.abs());
        let mut more = problem.tangents(&settled.coefficients);
        more.push(delay_rows);
        let (columns, solution) = problem.solve_with(&more);
        return Trimmed { problem, columns, solution, instruments: None, delay_s, refused_delay_s: None };
    }
    let (columns, solution) = problem.solve_with(&tangents);
    Trimmed {
        problem,
        columns,
        solution,
        instruments: None,
        delay_s: 0.0,
        refused_delay_s: (significant && worthwhile).then_some(delay_s),
    }
}

/// The problem as it is, without a delay.
pub(super) fn untrimmed(problem: Problem<'_>) -> Trimmed<'_> {
    let solution = problem.solve();
    let tangents = problem.tangents(&solution.coefficients);
    let (columns, solution) = problem.solve_with(&tangents);
    Trimmed { problem, columns, solution, instruments: None, delay_s: 0.0, refused_delay_s: None }
}
