//! The generalised least squares mean of vectors with covariances, and whether they agree.
//!
//! With captures xᵢ = Aᵢ·β + errors of covariance Vᵢ (Aᵢ picks the parameters that capture i estimates), the mean is
//! β = (Σ AᵢᵀVᵢ⁻¹Aᵢ)⁻¹ Σ AᵢᵀVᵢ⁻¹xᵢ (A. C. Aitken, Proc. Roy. Soc. Edinburgh 55, 1935, 42–48). The weighted sum of squares
//! of the deviations from the mean, X² = Σ rᵢᵀVᵢ⁻¹rᵢ, follows χ² if the captures differ by no more than their covariances say.
//! √(X²/degrees of freedom) is the ratio of R. T. Birge (Phys. Rev. 40, 1932, 207–227). The covariances are themselves estimates
//! with some 50 degrees of freedom, so that their inverses are too large on average: X² is compared with the F distribution
//! that S. Johansen derives (Biometrika 67, 1980, 85–92).

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};

use super::observation::{Observation, position};
use super::{Agreement, scalar};

/// Added to the ones of each correlation matrix, so that rounding does not make it indefinite.
const RIDGE: f64 = 1e-9;

/// Returns the mean of the observations, allowing for scatter between them, and whether they agree without that scatter.
pub(super) fn mean(observations: &[Observation]) -> (Observation, Option<Agreement>) {
    let mut names: Vec<&'static str> = Vec::new();
    for name in observations.iter().flat_map(|one| &one.names) {
        if !names.contains(name) {
            names.push(name);
        }
    }
    let estimated = |name: &str| -> Vec<(f64, f64)> {
        observations
            .iter()
            .filter_map(|one| position(&one.names, name).map(|at| (one.values[at], one.covariance[(at, at)])))
            .collect()
    };
    let substitutes: Vec<f64> = names.iter().map(|name| scalar::substitute(&estimated(name))).collect();
    let each = names.iter().zip(&substitutes);
    let scatter: Vec<f64> =
        each.map(|(name, substitute)| scalar::between(&scalar::substituted(&estimated(name), *substitute))).collect();
    let problem = Problem { names: &names, substitutes: &substitutes, observations };
    let none = vec![0.0; names.len()];
    let alike = problem.solve(&none, &none);
    let agreement = problem.agreement(&alike);
    // A parameter without covariances with others takes no part in the agreement.
    let agree = agreement.is_none_or(|agreement| agreement.agrees());
    let joint: Vec<bool> = names
        .iter()
        .map(|name| observations.iter().any(|one| position(&one.names, name).is_some_and(|at| one.joint[at])))
        .collect();
    let weighing: Vec<f64> =
        scatter.iter().zip(&joint).map(|(scatter, joint)| if agree && *joint { 0.0 } else { *scatter }).collect();
    let widening: Vec<f64> = scatter.iter().zip(&weighing).map(|(scatter, weighing)| scatter - weighing).collect();
    let (values, mut covariance) = problem.solve(&weighing, &widening);
    for (at, name) in names.iter().enumerate() {
        let uncertain = scatter[at] > 0.0 || estimated(name).iter().any(|one| one.1 > 0.0);
        if !uncertain {
            covariance.row_mut(at).fill(0.0);
            covariance.column_mut(at).fill(0.0);
        }
    }
    let degrees_of_freedom = observations.iter().map(|one| one.degrees_of_freedom).sum();
    let values = values.iter().copied().collect();
    (Observation { values, covariance, joint, names, degrees_of_freedom }, agreement)
}

struct Problem<'a> {
    names: &'a [&'static str],
    /// Variance of each parameter to use where an observation has none; also the parameter's scale.
    substitutes: &'a [f64],
    observations: &'a [Observation],
}

impl Problem<'_> {
    /// Indices of an observation's parameters in `names`.
    fn places(&self, observation: &Observation) -> Vec<usize> {
        observation.names.iter().filter_map(|name| position(self.names, name)).collect()
    }

    /// Cholesky factor of an observation's correlation matrix, with `scatter` added to the variances, and the standard deviations.
    fn factor(&self, observation: &Observation, scatter: &[f64]) -> (Option<Cholesky<f64, Dyn>>, DVector<f64>) {
        let places = self.places(observation);
        let variance = |at: usize| {
            let own = observation.covariance[(at, at)];
            (if own > 0.0 { own } else { self.substitutes[places[at]] }) + scatter[places[at]]
        };
        let count = places.len();
        let deviations = DVector::from_fn(count, |at, _| variance(at).sqrt());
        let correlation = DMatrix::from_fn(count, count, |row, column| {
            if row == column {
                1.0 + RIDGE
            } else {
                observation.covariance[(row, column)] / (deviations[row] * deviations[column])
            }
        });
        // If the matrix is not positive definite, only its diagonal is used.
        let factor = Cholesky::new(correlation).or_else(|| Cholesky::new(DMatrix::identity(count, count)));
        (factor, deviations)
    }

    /// Values and covariance of the mean, with variances from capture to capture added to those of every observation:
    /// `weighing` count in weights and covariance, `widening` in the covariance alone.
    fn solve(&self, weighing: &[f64], widening: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let count = self.names.len();
        let scales: Vec<f64> = self.substitutes.iter().map(|variance| variance.sqrt()).collect();
        // Relative to the first estimate, so that phases and small periods keep their digits.
        let origin: Vec<f64> = (0..count)
            .map(|at| {
                let first = |one: &Observation| position(&one.names, self.names[at]).map(|place| one.values[place]);
                self.observations.iter().find_map(first).unwrap_or(0.0)
            })
            .collect();
        let mut normal = DMatrix::<f64>::zeros(count, count);
        let mut right = DVector::<f64>::zeros(count);
        let mut middle = DMatrix::<f64>::zeros(count, count);
        let widening =
            DMatrix::from_diagonal(&DVector::from_fn(count, |at, _| widening[at] / (scales[at] * scales[at])));
        for observation in self.observations {
            let places = self.places(observation);
            let (Some(factor), deviations) = self.factor(observation, weighing) else { continue };
            // Selects the observation's parameters; columns count in `scales`, rows in the observation's standard deviations.
            let design = DMatrix::from_fn(places.len(), count, |row, column| {
                if places[row] == column { scales[column] / deviations[row] } else { 0.0 }
            });
            let whitened = |at: usize| (observation.values[at] - origin[places[at]]) / deviations[at];
            right += design.tr_mul(&factor.solve(&DVector::from_fn(places.len(), |at, _| whitened(at))));
            let weight = design.tr_mul(&factor.solve(&design));
            middle += &weight * &widening * &weight;
            normal += weight;
        }
        let Some(factor) = Cholesky::new(normal) else {
            return (DVector::from_vec(origin), DMatrix::zeros(count, count));
        };
        let solution = factor.solve(&right);
        let inverse = factor.inverse();
        let inverse = &inverse + &inverse * middle * &inverse;
        (
            DVector::from_fn(count, |at, _| origin[at] + scales[at] * solution[at]),
            DMatrix::from_fn(count, count, |row, column| scales[row] * scales[column] * inverse[(row, column)]),
        )
    }

    /// χ² of the observations' deviations from their mean, over the parameters whose covariance a fit gave.
    ///
    /// With ν degrees of freedom of each covariance, Johansen's sum over the observations
    /// A = Σ (tr Mᵢ² + (tr Mᵢ)²)/2νᵢ, Mᵢ = 1 − H⁻¹·Vᵢ⁻¹ and H = Σ Vᵢ⁻¹, gives the law χ² ~ c·F(f, f₂) with f₂ = f·(f + 2)/3A
    /// and c = f + 2A − 6A/(f + 2).
    fn agreement(&self, (mean, of_mean): &(DVector<f64>, DMatrix<f64>)) -> Option<Agreement> {
        let none = vec![0.0; self.names.len()];
        let (mut chi_squared, mut estimated, mut uncertain) = (0.0, 0, 0.0);
        let mut parameters = vec![false; self.names.len()];
        for observation in self.observations {
            let places = self.places(observation);
            let (Some(factor), deviations) = self.factor(observation, &none) else { continue };
            // A parameter without a covariance from the fit is uncorrelated with the rest: a deviation of zero leaves it out.
            let left = DVector::from_fn(places.len(), |at, _| {
                if observation.joint[at] { (observation.values[at] - mean[places[at]]) / deviations[at] } else { 0.0 }
            });
            chi_squared += left.dot(&factor.solve(&left));
            let joint: Vec<usize> = (0..places.len()).filter(|at| observation.joint[*at]).collect();
            if joint.is_empty() {
                continue;
            }
            let weight = DMatrix::from_fn(places.len(), places.len(), |row, column| {
                of_mean[(places[row], places[column])] / deviations[column]
            }) * factor.inverse();
            let remainder = DMatrix::from_fn(joint.len(), joint.len(), |row, column| {
                f64::from(row == column) - weight[(joint[row], joint[column])] / deviations[joint[column]]
            });
            uncertain += ((&remainder * &remainder).trace() + remainder.trace().powi(2))
                / (2.0 * observation.degrees_of_freedom);
            for (at, place) in places.iter().enumerate().filter(|(at, _)| observation.joint[*at]) {
                estimated += usize::from(observation.covariance[(at, at)] > 0.0);
                parameters[*place] = true;
            }
        }
        let degrees_of_freedom = estimated.saturating_sub(parameters.iter().filter(|estimated| **estimated).count());
        if degrees_of_freedom == 0 {
            return None;
        }
        let freedom = degrees_of_freedom as f64;
        Some(Agreement {
            chi_squared,
            degrees_of_freedom,
            probability: probability(chi_squared, freedom, uncertain),
            birge_ratio: (chi_squared / freedom).sqrt(),
        })
    }
}

/// Probability of a χ² at least as large with `freedom` degrees of freedom; `uncertain` is Johansen's A, the covariances' own uncertainty.
fn probability(chi_squared: f64, freedom: f64, uncertain: f64) -> f64 {
    // The bound stands in for the infinite degrees of freedom of covariances that are known exactly.
    let freedom_below = (freedom * (freedom + 2.0) / (3.0 * uncertain)).min(1e6);
    let scale = freedom + 2.0 * uncertain - 6.0 * uncertain / (freedom + 2.0);
    FisherSnedecor::new(freedom, freedom_below).map_or(0.0, |law| law.sf(chi_squared / scale))
}
