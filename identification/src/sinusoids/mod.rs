//! Sinusoids of the angle in a torque: how much each takes off a sum of squares, and which stand out of noise.

mod fourier_sums;
pub(crate) mod matching_pursuit;
pub(crate) mod reduction;
pub(crate) mod scan;

use crate::numerics::statistics::median;

/// Wavenumbers tried per width of a peak.
pub(crate) const OVERSAMPLING: usize = 4;
/// Fewest periods that the travel must hold for a period to be estimated.
pub(crate) const FEWEST_PERIODS: f64 = 1.25;
/// Margin of [`threshold`] by which the strongest of several sinusoids of noise lies above it in one case of twenty.
pub(crate) const MARGIN: f64 = 6.0;
/// Standard errors by which a sinusoid must predict stretches of the capture that it was not fitted to.
pub(crate) const PREDICTS: f64 = 3.0;

/// What the strongest of so many independent sinusoids takes off a sum of squares of white noise, in units of the noise's
/// variance: each takes χ² with two degrees of freedom, and with probability e^(−margin/2) one takes more than this.
pub(crate) fn threshold(independent: f64, margin: f64) -> f64 {
    2.0 * independent.max(1.0).ln() + margin
}

/// Variance of noise from what sinusoids take off its sum of squares, most of them of noise alone: χ² with two degrees of
/// freedom has the median 2·ln 2. Reorders the values.
pub(crate) fn noise_variance(reductions: &mut [f64]) -> f64 {
    median(reductions) / (2.0 * 2_f64.ln())
}

/// Vertex of the parabola through a peak and its neighbours, in steps from the peak; zero at an end.
pub(crate) fn vertex(values: &[f64], peak: usize) -> f64 {
    let neighbours = peak.checked_sub(1).and_then(|left| Some((values[left], *values.get(peak + 1)?)));
    let Some((left, right)) = neighbours else { return 0.0 };
    let bend = 2.0 * values[peak] - left - right;
    if bend > 0.0 { (0.5 * (right - left) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}
