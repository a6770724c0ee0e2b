//! The stationary smoother as a pair of filters: encoder where it is quieter, accelerometer where that is.

use std::f64::consts::{PI, SQRT_2};

use super::Sensors;

/// Samples around a gap at which the encoder's second derivative is that of the bridge.
const NEAR_GAP: usize = 8;

/// The fused angle, of which velocity and acceleration are the derivatives, rad.
///
/// With d the accelerometer's reading less the encoder's second derivative, the acceleration θ̈ + (1 − W)·d is that of
/// the angle θ + K·d with K = (1 − W)/s² = −G(s)·G(−s), G(s) = s/(s² + √2·ω₀·s + ω₀²): a band-pass run forwards and
/// backwards. As only the sensors' disagreement is filtered, a motion on which they agree passes unchanged.
pub(crate) fn blend(sensors: &Sensors<'_>) -> Vec<f64> {
    let mut correction: Vec<f64> = sensors
        .prompt_rad_s2
        .iter()
        .zip(&sensors.second_derivative_rad_s2)
        .map(|(sensor, encoder)| sensor - encoder)
        .collect();
    without_gaps(&mut correction, sensors.present);
    let section = BandPass::new(sensors.equal_hz, sensors.rate_hz);
    section.run(&mut correction);
    correction.reverse();
    section.run(&mut correction);
    correction.reverse();
    // Run both ways the band-pass gives G(s)·G(−s), which is −K.
    sensors.angle_rad.iter().zip(&correction).map(|(angle, more)| angle - more).collect()
}

fn without_gaps(signal: &mut [f64], present: &[bool]) {
    let last = signal.len().saturating_sub(1);
    let mut from = 0;
    for index in (0..present.len()).filter(|index| !present[*index]) {
        let (start, end) = (index.saturating_sub(NEAR_GAP).max(from), (index + NEAR_GAP).min(last));
        if start <= end {
            signal[start..=end].fill(0.0);
        }
        from = end;
    }
}

/// s/(s² + √2·ω₀·s + ω₀²) by the bilinear transform, true at ω₀.
struct BandPass {
    gain: f64,
    feedback: [f64; 2],
}

impl BandPass {
    fn new(centre_hz: f64, rate_hz: f64) -> Self {
        let scale = 2.0 * rate_hz;
        let centre = scale * (PI * centre_hz / rate_hz).tan();
        let (square, middle, last) = (scale * scale, SQRT_2 * centre * scale, centre * centre);
        let first = square + middle + last;
        Self { gain: scale / first, feedback: [2.0 * (last - square) / first, (square - middle + last) / first] }
    }

    /// Filters in place, from rest.
    fn run(&self, signal: &mut [f64]) {
        let [a1, a2] = self.feedback;
        let (mut in1, mut in2, mut out1, mut out2) = (0.0, 0.0, 0.0, 0.0);
        for value in signal {
            let out = self.gain * (*value - in2) - a1 * out1 - a2 * out2;
            (in2, in1) = (in1, *value);
            (out2, out1) = (out1, out);
            *value = out;
        }
    }
}
