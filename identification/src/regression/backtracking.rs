//! A step that is shortened until it improves.

/// Shares of a step that are tried.
const TRIALS: usize = 4;

/// What the longest share of a step gives for which `improved` gives anything; shares fall by `factor`, from the whole step on.
pub(crate) fn longest_improving<T>(factor: f64, improved: impl FnMut(f64) -> Option<T>) -> Option<T> {
    std::iter::successors(Some(1.0), |share| Some(factor * share)).take(TRIALS).find_map(improved)
}
