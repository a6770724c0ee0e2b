//! Lowering a sum of squares step by step.
//!
//! The steps differ: Gauss and Newton's with all linear coefficients solved anew, or Levenberg and Marquardt's where a body is simulated.
//! The rules for going on and for stopping are the same.

/// Shares of a step that are tried.
const TRIALS: usize = 4;

/// Why a refinement ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// A step took off next to nothing, or would.
    Settled,
    /// No step took off anything.
    NoStepImproves,
    /// All steps were taken.
    OutOfSteps,
}

/// Takes at most so many steps, until one takes off less than the share `settled` of the sum of squares.
///
/// `step` is given the sum of squares and returns that after a step, or why there is none.
pub(crate) fn refine(
    steps: usize,
    settled: f64,
    mut squares: f64,
    mut step: impl FnMut(f64) -> Result<f64, Ended>,
) -> Ended {
    for _ in 0..steps {
        match step(squares) {
            Ok(after) if squares - after > settled * squares => squares = after,
            Ok(_) => return Ended::Settled,
            Err(ended) => return ended,
        }
    }
    Ended::OutOfSteps
}

/// Tries the whole step, then shares that shrink by `factor`; returns the first result that `improved` gives.
pub(crate) fn longest_improving<T>(factor: f64, improved: impl FnMut(f64) -> Option<T>) -> Result<T, Ended> {
    let mut shares = std::iter::successors(Some(1.0), |share| Some(factor * share)).take(TRIALS);
    shares.find_map(improved).ok_or(Ended::NoStepImproves)
}
