//! Means of single numbers with intervals.

use crate::numerics::statistics::NORMAL_95;

/// A value with the half width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimated {
    /// Value.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub half_width: f64,
}

/// The weighted mean of values with half widths, scatter between them included.
pub(crate) fn combined(estimated: &[(f64, f64)]) -> Estimated {
    let estimated: Vec<(f64, f64)> = estimated.iter().map(|one| (one.0, (one.1 / NORMAL_95).powi(2))).collect();
    let known = substituted(&estimated, substitute(&estimated));
    let between = between(&known);
    let (value, total) = weighted(&known, between);
    let is_uncertain = between > 0.0 || estimated.iter().any(|one| one.1 > 0.0);
    Estimated { value, half_width: if is_uncertain { NORMAL_95 / total.sqrt() } else { 0.0 } }
}

/// The variance to use for a value without one: the smallest positive variance of these values, or 1 if there is none.
pub(super) fn substitute(estimated: &[(f64, f64)]) -> f64 {
    let least = estimated.iter().map(|one| one.1).filter(|own| *own > 0.0).fold(f64::INFINITY, f64::min);
    if least.is_finite() { least } else { 1.0 }
}

/// Values with variances, a substitute for those without one.
pub(super) fn substituted(estimated: &[(f64, f64)], substitute: f64) -> Vec<(f64, f64)> {
    estimated.iter().map(|(value, own)| (*value, if *own > 0.0 { *own } else { substitute })).collect()
}

/// Variance between the values that their own variances do not explain, after DerSimonian and Laird; zero if they explain
/// everything.
pub(super) fn between(known: &[(f64, f64)]) -> f64 {
    let (fixed, total) = weighted(known, 0.0);
    let excess: f64 = known.iter().map(|(value, own)| (value - fixed).powi(2) / own).sum();
    let squares: f64 = known.iter().map(|(_, own)| own.powi(-2)).sum();
    let scale = total - squares / total;
    if scale > 0.0 { ((excess + 1.0 - known.len() as f64) / scale).max(0.0) } else { 0.0 }
}

/// Mean of values with variances, all of them enlarged by `between`, and the sum of the weights.
fn weighted(known: &[(f64, f64)], between: f64) -> (f64, f64) {
    let weights = known.iter().map(|(_, own)| 1.0 / (own + between));
    let total: f64 = weights.clone().sum();
    (known.iter().zip(weights).map(|(one, weight)| weight * one.0).sum::<f64>() / total, total)
}
