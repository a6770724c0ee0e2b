//! One trajectory from two sensors: the encoder's angle and the accelerometer's acceleration.
//!
//! Both noises are white where they enter, with densities S_θ (rad²/Hz) and S_a (rad²/s⁴ per Hz). At angular frequency
//! ω the encoder sees the acceleration with the noise ω⁴·S_θ, the accelerometer with S_a, so the best weights are
//!
//! ```text
//! W(ω) = 1/(1 + (ω/ω₀)⁴) for the encoder, 1 − W for the accelerometer,   ω₀⁴ = S_a/S_θ
//! ```
//!
//! That is the stationary fixed-interval Kalman smoother of a motion of which nothing is known beforehand ([`blend`]).

use std::f64::consts::{PI, SQRT_2, TAU};

use crate::numerics::derivative::gradient;
use crate::numerics::lag::prompt;
use crate::preparation::filter::{Sections, low_pass};
use crate::preparation::row_filter::blank_runs;
use crate::preparation::spectrum::{Spectrum, white_density};
use crate::regression::least_squares::LeastSquares;

/// Largest disagreement of both sensors, relative, where both see well.
const DISAGREEMENT: f64 = 0.1;

/// The encoder's noise is read from this multiple of the frequency at which both are equally noisy.
const CLEAR_OF_SENSOR: f64 = 1.5;

/// Samples around a gap at which the encoder's second derivative is that of the bridge.
const NEAR_GAP: usize = 8;

/// What both sensors gave, on an even grid.
pub(crate) struct Sensors<'a> {
    /// Angle of the knob, rad.
    angle_rad: &'a [f64],
    /// Acceleration with the sensor's lag undone, rad/s².
    prompt_rad_s2: Vec<f64>,
    second_derivative_rad_s2: Vec<f64>,
    /// Whether a grid point was measured.
    present: &'a [bool],
    lag_s: f64,
    rate_hz: f64,
    /// White density of the encoder's noise, rad²/Hz.
    pub(crate) angle_density: f64,
    /// White density of the accelerometer's noise, rad²/s⁴ per Hz.
    pub(crate) sensor_density: f64,
    /// Frequency at which both sensors are equally noisy, Hz.
    pub(crate) equal_hz: f64,
}

impl<'a> Sensors<'a> {
    /// The sensors with their noise as their own spectra show it; `encoder_rad` is the angle before it was corrected.
    ///
    /// `None` if the encoder is quieter over the whole of the band up to `cutoff_hz`, or if the two do not agree
    /// where both see well.
    pub(crate) fn of(
        angle_rad: &'a [f64],
        encoder_rad: &[f64],
        acceleration_rad_s2: &[f64],
        present: &'a [bool],
        lag_s: f64,
        rate_hz: f64,
        cutoff_hz: f64,
    ) -> Option<Self> {
        let angle_density = white_density(encoder_rad, rate_hz);
        let sensor_density = Spectrum::welch(acceleration_rad_s2, rate_hz).median(0.3 * rate_hz, 0.45 * rate_hz);
        let equal_hz = (sensor_density / angle_density).powf(0.25) / TAU;
        let sensors = Self {
            angle_rad,
            prompt_rad_s2: prompt(acceleration_rad_s2, lag_s, rate_hz),
            second_derivative_rad_s2: gradient(&gradient(angle_rad, rate_hz), rate_hz),
            present,
            lag_s,
            rate_hz,
            angle_density,
            sensor_density,
            equal_hz,
        };
        let takes_part = |sensors: &Self| sensors.equal_hz > 0.0 && sensors.equal_hz < cutoff_hz;
        let sensors = Some(sensors).filter(takes_part)?.with_density_in_band(cutoff_hz);
        (takes_part(&sensors) && sensors.agree()).then_some(sensors)
    }

    /// The sensors with the encoder's noise read from their disagreement, just above the frequency of equal noise: the steps of
    /// a coarse encoder make less noise there than at the upper end of the spectrum, where a moving knob puts them.
    fn with_density_in_band(mut self, cutoff_hz: f64) -> Self {
        let turns = CLEAR_OF_SENSOR * self.equal_hz..=cutoff_hz;
        let density = Spectrum::welch(&self.disagreement(), self.rate_hz).median_of(turns, |frequency_hz, density| {
            let square = (TAU * frequency_hz).powi(2);
            (density - self.sensor_density * (1.0 + square * self.lag_s.powi(2))) / (square * square)
        });
        if density > 0.0 {
            self.angle_density = density;
            self.equal_hz = (self.sensor_density / density).powf(0.25) / TAU;
        }
        self
    }

    /// The accelerometer's reading less the encoder's second derivative, rad/s².
    fn disagreement(&self) -> Vec<f64> {
        self.prompt_rad_s2
            .iter()
            .zip(&self.second_derivative_rad_s2)
            .map(|(sensor, encoder)| sensor - encoder)
            .collect()
    }

    /// Whether the accelerometer's gain on the encoder's acceleration is one below the frequency where they are equally noisy.
    fn agree(&self) -> bool {
        let slow = |signal: &[f64]| low_pass(4, self.equal_hz, self.rate_hz, signal);
        let (encoder, sensor) = (slow(&self.second_derivative_rad_s2), slow(&self.prompt_rad_s2));
        let gain = LeastSquares::solve(&[vec![1.0; encoder.len()], encoder], &sensor).coefficients[1];
        (gain - 1.0).abs() <= DISAGREEMENT
    }
}

/// The fused angle, of which velocity and acceleration are the derivatives, rad.
///
/// With d the accelerometer's reading less the encoder's second derivative, the acceleration θ̈ + (1 − W)·d is that of
/// the angle θ + K·d with K = (1 − W)/s² = −G(s)·G(−s), G(s) = s/(s² + √2·ω₀·s + ω₀²): a band-pass run forwards and
/// backwards. As only the sensors' disagreement is filtered, a motion on which they agree passes unchanged.
pub(crate) fn blend(sensors: &Sensors<'_>) -> Vec<f64> {
    let mut correction = sensors.disagreement();
    blank_runs(&mut correction, sensors.present, |is_present| !is_present, |_| NEAR_GAP);
    let band_pass = band_pass(sensors.equal_hz, sensors.rate_hz);
    for _ in 0..2 {
        correction = band_pass.filter(&correction, 0.0);
        correction.reverse();
    }
    // Run both ways the band-pass gives G(s)·G(−s), which is −K.
    sensors.angle_rad.iter().zip(&correction).map(|(angle, more)| angle - more).collect()
}

/// s/(s² + √2·ω₀·s + ω₀²) in its bilinear transform, true at ω₀.
fn band_pass(centre_hz: f64, rate_hz: f64) -> Sections {
    let scale = 2.0 * rate_hz;
    let centre = scale * (PI * centre_hz / rate_hz).tan();
    let (square, middle, last) = (scale * scale, SQRT_2 * centre * scale, centre * centre);
    let first = square + middle + last;
    let (gain, a1, a2) = (scale / first, 2.0 * (last - square) / first, (square - middle + last) / first);
    Sections::of_one([gain, 0.0, -gain, 1.0, a1, a2])
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use rand_distr::{Distribution as _, StandardUniform};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng as _;

    use super::{Sensors, blend};
    use crate::numerics::derivative::gradient;
    use crate::numerics::statistics::rms;
    use crate::preparation::filter::low_pass;

    const RATE_HZ: f64 = 2000.0;
    const STEP_RAD: f64 = TAU / 16_384.0;
    const NOISE_RAD_S2: f64 = 2.8;

    /// Angle and acceleration of a motion between 1 and 30 Hz, true and as the sensors see it.
    fn motion(seed: u64) -> [Vec<f64>; 4] {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut uniform = move || -> f64 { StandardUniform.sample(&mut random) };
        let tones: Vec<(f64, f64, f64)> =
            (0..30).map(|n| (1.0 + f64::from(n) + uniform(), TAU * uniform(), 40.0)).collect();
        let (mut angle, mut acceleration) = (Vec::new(), Vec::new());
        for index in 0..16_000 {
            let time_s = f64::from(index) / RATE_HZ;
            let wave = |(frequency, phase, _): &(f64, f64, f64)| (TAU * frequency * time_s + phase).sin();
            acceleration.push(tones.iter().map(|tone| tone.2 * wave(tone)).sum());
            angle.push(tones.iter().map(|tone| -tone.2 * wave(tone) / (TAU * tone.0).powi(2)).sum());
        }
        let encoder = angle.iter().map(|angle: &f64| (angle / STEP_RAD).round() * STEP_RAD).collect();
        let sensor =
            acceleration.iter().map(|value: &f64| value + NOISE_RAD_S2 * 12_f64.sqrt() * (uniform() - 0.5)).collect();
        [angle, acceleration, encoder, sensor]
    }

    /// RMS error in the band of the motion, ends left out.
    fn error(estimate: &[f64], truth: &[f64]) -> f64 {
        let difference: Vec<f64> = estimate.iter().zip(truth).map(|(estimate, truth)| estimate - truth).collect();
        rms(&low_pass(4, 60.0, RATE_HZ, &difference)[2000..14_000])
    }

    #[test]
    fn the_blend_is_better_than_either_sensor() {
        let present = vec![true; 16_000];
        let (mut blended, mut encoder_alone, mut sensor_alone) = (0.0, 0.0, 0.0);
        for seed in 1..=8 {
            let [_, truth, encoder, sensor] = motion(seed);
            let sensors = Sensors::of(&encoder, &encoder, &sensor, &present, 0.0, RATE_HZ, 300.0).expect("they agree");
            let twice = |angle: &[f64]| gradient(&gradient(angle, RATE_HZ), RATE_HZ);
            blended += error(&twice(&blend(&sensors)), &truth);
            encoder_alone += error(&twice(&encoder), &truth);
            sensor_alone += error(&sensor, &truth);
        }
        assert!(blended < sensor_alone.min(encoder_alone), "{blended}, alone {encoder_alone} and {sensor_alone}");
    }

    #[test]
    fn a_gap_leaves_the_angle_as_it_was_bridged() {
        let [_, _, encoder, sensor] = motion(3);
        let present = vec![false; encoder.len()];
        let sensors = Sensors::of(&encoder, &encoder, &sensor, &present, 0.0, RATE_HZ, 300.0).expect("they agree");
        assert!(blend(&sensors).iter().zip(&encoder).all(|(fused, angle)| (fused - angle).abs() < 1e-12));
    }
}
