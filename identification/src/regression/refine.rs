//! The search for the parameters that make a fit nonlinear: Gauss–Newton steps, shortened or damped until they help.
//!
//! Damping is that of K. Levenberg (Quart. Appl. Math. 2, 1944, 164–168) and D. W. Marquardt (J. SIAM 11, 1963, 431–441).

use std::ops::Deref;

use nalgebra::{DMatrix, DVector};

use super::least_squares::LeastSquares;
use crate::vector::{self, dot};

/// Share of a parameter's own curvature below which the rest of the fit can do the same: it stays where it is.
const COLLINEAR: f64 = 1e-9;

/// A fit that a step of its searched parameters may improve.
pub(crate) trait Refined {
    /// Sum of squares that it leaves.
    fn squares(&self) -> f64;

    /// Curvature and slope along the searched parameters, everything else moving along: the solution of both is the step.
    fn normal_equations(&mut self) -> (DMatrix<f64>, DVector<f64>);

    /// Shortens a step to what is sensible in one go.
    fn limit(&self, _step: &mut DVector<f64>) {}

    /// Takes a step if that leaves less than before; whether it did.
    fn go(&mut self, step: &DVector<f64>) -> bool;

    /// Forgets derivatives that were only updated since they were taken; whether there were such.
    fn renew(&mut self) -> bool {
        false
    }
}

/// How a step that does not help is changed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Damping {
    /// At first, as a share of the curvature; …
    first: f64,
    /// … multiplied by this after a step that helped, …
    lowered: f64,
    /// … and by this after one that did not.
    raised: f64,
    /// A step that did not help is multiplied by this.
    shortened: f64,
    tries: usize,
}

impl Damping {
    /// None: columns follow well, and steps are shortened.
    pub(crate) const NONE: Self = Self { first: 0.0, lowered: 1.0, raised: 1.0, shortened: 0.25, tries: 4 };
    /// For simulations, which may do anything further away.
    pub(crate) const SIMULATED: Self = Self { first: 1e-3, lowered: 0.2, raised: 6.0, shortened: 1.0, tries: 6 };
    /// Least damping, once there is any.
    const LEAST: f64 = 1e-7;
}

/// Why a search ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// A further step would take off too little to be worth it.
    Settled,
    /// No step along the slope leaves less, however short.
    NoDescent,
    /// The curvature is not positive: the data do not bound the parameters.
    Unbounded,
    /// All rounds were used up while steps still helped.
    OutOfRounds,
}

/// Improves a fit by at most `rounds` steps; one that would take off less than `settled` of the sum of squares is not taken.
pub(crate) fn refine(fit: &mut impl Refined, rounds: usize, settled: f64, rule: Damping) -> Ended {
    let mut damping = rule.first;
    'rounds: for _ in 0..rounds {
        let before = fit.squares();
        let (curvature, slope) = fit.normal_equations();
        let mut share = 1.0;
        for attempt in 0..rule.tries {
            let mut damped = curvature.clone();
            for at in 0..slope.len() {
                let own = curvature[(at, at)];
                damped[(at, at)] = if own > 0.0 { own * (1.0 + damping) } else { 1.0 };
            }
            let Some(mut step) = damped.cholesky().map(|factor| factor.solve(&slope)) else { return Ended::Unbounded };
            if attempt == 0 && step.dot(&slope) <= settled * before {
                if fit.renew() {
                    continue 'rounds;
                }
                return Ended::Settled;
            }
            fit.limit(&mut step);
            if fit.go(&(step * share)) {
                damping = (rule.lowered * damping).max(Damping::LEAST.min(rule.first));
                if before - fit.squares() < settled * before && !fit.renew() {
                    return Ended::Settled;
                }
                continue 'rounds;
            }
            if fit.renew() {
                // Updated derivatives may be what is wrong.
                continue 'rounds;
            }
            share *= rule.shortened;
            damping *= rule.raised;
        }
        return Ended::NoDescent;
    }
    Ended::OutOfRounds
}

/// Curvature and slope along `tangents`, a solution's coefficients moving along.
pub(crate) fn projected<C: Deref<Target = [f64]>, T: Deref<Target = [f64]>>(
    solution: &LeastSquares,
    columns: &[C],
    tangents: &[T],
) -> (DMatrix<f64>, DVector<f64>) {
    let count = tangents.len();
    let mut slope = DVector::from_iterator(count, tangents.iter().map(|tangent| dot(tangent, &solution.residual)));
    let cross = DMatrix::from_fn(columns.len(), count, |row, column| dot(&columns[row], &tangents[column]));
    let mut curvature = DMatrix::zeros(count, count);
    vector::products(tangents, 0, &mut curvature);
    let own = curvature.diagonal();
    // What of the tangents the columns themselves cannot do.
    curvature -= cross.transpose() * &solution.inverse * &cross;
    for at in 0..count {
        if curvature[(at, at)].is_nan() || curvature[(at, at)] <= COLLINEAR * own[at] {
            curvature.row_mut(at).fill(0.0);
            curvature.column_mut(at).fill(0.0);
            (curvature[(at, at)], slope[at]) = (1.0, 0.0);
        }
    }
    (curvature, slope)
}
