//! Derivatives of evenly sampled signals.

use super::vector;

/// Samples on each side that [`gradient`] looks at.
pub(crate) const GRADIENT_REACH: usize = 4;
/// Weights of the differences between the samples 1, 2, … behind and before a sample, of eighth order.
pub(crate) const GRADIENT_WEIGHTS: [f64; GRADIENT_REACH] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];

/// Derivative per second by central differences of eighth order, of lower order towards the ends.
///
/// Plain central differences take (ωh)²/6 off a signal, ω its frequency and h the sample period: at 100 Hz and
/// 10 kHz that already shifts an inertia by more than its interval. Eighth order takes off (ωh)⁸/630.
pub(crate) fn gradient(signal: &[f64], rate_hz: f64) -> Vec<f64> {
    const WEIGHTS: [&[f64]; GRADIENT_REACH] =
        [&[1.0 / 2.0], &[2.0 / 3.0, -1.0 / 12.0], &[3.0 / 4.0, -3.0 / 20.0, 1.0 / 60.0], &GRADIENT_WEIGHTS];
    let last = signal.len() - 1;
    let towards_end = |index: usize| match index.min(last - index).min(WEIGHTS.len()) {
        0 => rate_hz * (signal[(index + 1).min(last)] - signal[index.saturating_sub(1)]),
        order => {
            let pairs = WEIGHTS[order - 1].iter().zip(1..);
            rate_hz * pairs.map(|(weight, at)| weight * (signal[index + at] - signal[index - at])).sum::<f64>()
        }
    };
    let weights = GRADIENT_WEIGHTS.map(|weight| weight * rate_hz);
    let mut rate = vec![0.0; signal.len()];
    let inside = GRADIENT_REACH..signal.len().saturating_sub(GRADIENT_REACH);
    if !inside.is_empty() {
        vector::differences(signal, weights, &mut rate[inside.clone()]);
    }
    for index in (0..signal.len()).filter(|index| !inside.contains(index)) {
        rate[index] = towards_end(index);
    }
    rate
}
