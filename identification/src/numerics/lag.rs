//! A first-order lag and its inverse.

use super::derivative::gradient;

/// The signal behind a first-order low-pass with a time constant of `lag` samples, exact for straight lines between samples.
pub(crate) fn lagged(signal: &[f64], lag: f64) -> Vec<f64> {
    let Some(first) = signal.first().filter(|_| lag > 0.0) else {
        return signal.to_vec();
    };
    let decay = (-1.0 / lag).exp();
    let (mut previous, mut state) = (*first, *first);
    signal
        .iter()
        .map(|value| {
            let slope = value - previous;
            // On a ramp the output trails by slope · lag; any further deviation decays.
            state = value - slope * lag + (state - previous + slope * lag) * decay;
            previous = *value;
            state
        })
        .collect()
}

/// A signal without its first-order lag, as accelerometers have at their output: lag times rate is added.
pub(crate) fn prompt(signal: &[f64], lag_s: f64, rate_hz: f64) -> Vec<f64> {
    let rate = gradient(signal, rate_hz);
    signal.iter().zip(&rate).map(|(value, rate)| value + lag_s * rate).collect()
}
