//! The fixed-interval smoother of Rauch, Tung and Striebel (AIAA Journal 3, 1965, 1445–1450).
//!
//! States: angle, velocity, acceleration, and the accelerometer's output behind its lag. The motion is driven by white
//! jerk, whose density the data choose: the one at which the filter's innovations are likeliest.

use nalgebra::{Matrix4, Vector4};

use super::Sensors;

/// Samples at the start of a capture from which the density of the jerk is chosen.
const LIKELIHOOD_SAMPLES: usize = 30_000;
/// Decades of jerk per sample period over which the likeliest is sought, relative to the accelerometer's noise.
const DECADES: std::ops::RangeInclusive<i32> = -12..=12;
/// A lag below this share of a sample period is none.
const NO_LAG: f64 = 0.01;

/// Smooths what both sensors gave over the whole capture: angle, velocity and acceleration at every grid point.
pub(crate) fn kalman_smoother(sensors: &Sensors<'_>) -> [Vec<f64>; 3] {
    let filter = likeliest(sensors);
    let mut steps = Vec::with_capacity(sensors.angle_rad.len());
    filter.run(sensors, sensors.angle_rad.len(), &mut steps);
    let mut states = vec![Vector4::zeros(); steps.len()];
    let Some(last) = steps.last() else { return Default::default() };
    let mut state = last.filtered;
    states[steps.len() - 1] = state;
    for index in (0..steps.len() - 1).rev() {
        let (now, next) = (&steps[index], &steps[index + 1]);
        let gain = next
            .predicted_covariance
            .cholesky()
            .map_or_else(Matrix4::zeros, |factor| factor.solve(&(filter.transition * now.covariance)).transpose());
        state = now.filtered + gain * (state - next.predicted);
        states[index] = state;
    }
    let period_s = 1.0 / sensors.rate_hz;
    let column = |(at, scale): (usize, f64)| states.iter().map(|state| state[at] / scale).collect();
    [(0, 1.0), (1, period_s), (2, period_s * period_s)].map(column)
}

/// The filter in units of the sample period: states θ, T·θ̇, T²·θ̈ and T² times the accelerometer's output, all in rad.
struct Filter {
    transition: Matrix4<f64>,
    process: Matrix4<f64>,
    /// Variances of one reading of each sensor, rad².
    noise: [f64; 2],
}

/// One sample of the forward pass.
struct Step {
    predicted: Vector4<f64>,
    predicted_covariance: Matrix4<f64>,
    filtered: Vector4<f64>,
    covariance: Matrix4<f64>,
}

impl Filter {
    /// A filter for jerk of variance `jerk` in one sample period, rad².
    fn new(sensors: &Sensors<'_>, jerk: f64) -> Self {
        let lag = sensors.lag_s * sensors.rate_hz;
        let mut drift = Matrix4::zeros();
        drift[(0, 1)] = 1.0;
        drift[(1, 2)] = 1.0;
        if lag > NO_LAG {
            drift[(3, 2)] = 1.0 / lag;
            drift[(3, 3)] = -1.0 / lag;
        }
        let impulse = |at: f64| (drift * at).exp() * Vector4::new(0.0, 0.0, 1.0, 0.0);
        // Gauss and Legendre's three points integrate the noise over one period.
        let process = [(0.5 - 0.15_f64.sqrt(), 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + 0.15_f64.sqrt(), 5.0 / 18.0)]
            .into_iter()
            .map(|(at, weight)| impulse(at) * impulse(at).transpose() * (weight * jerk))
            .sum::<Matrix4<f64>>();
        let half_rate_hz = 0.5 * sensors.rate_hz;
        let period_s = 1.0 / sensors.rate_hz;
        let noise = [sensors.angle_density * half_rate_hz, sensors.sensor_density * half_rate_hz * period_s.powi(4)];
        Self { transition: drift.exp(), process: process + Matrix4::identity() * (1e-12 * jerk), noise }
    }

    /// Filters the first `length` samples, keeping each step; returns the logarithm of their likelihood.
    fn run(&self, sensors: &Sensors<'_>, length: usize, steps: &mut Vec<Step>) -> f64 {
        let period_s = 1.0 / sensors.rate_hz;
        let lagging = self.transition[(3, 2)] > 0.0;
        let observed = [0, if lagging { 3 } else { 2 }];
        let start = [sensors.acceleration_rad_s2.first().copied().unwrap_or(0.0) * period_s * period_s; 2];
        let mut state = Vector4::new(sensors.angle_rad.first().copied().unwrap_or(0.0), 0.0, start[0], start[1]);
        // The knob's speed at the start is hardly known, its angle and acceleration as well as the sensors say.
        let mut covariance = Matrix4::from_diagonal(&Vector4::new(
            100.0 * self.noise[0],
            1e-4,
            100.0 * self.noise[1],
            100.0 * self.noise[1],
        ));
        let mut likelihood = 0.0;
        for index in 0..length {
            let (predicted, predicted_covariance) = if index == 0 {
                (state, covariance)
            } else {
                let moved = self.transition * covariance * self.transition.transpose() + self.process;
                (self.transition * state, 0.5 * (moved + moved.transpose()))
            };
            (state, covariance) = (predicted, predicted_covariance);
            if sensors.present[index] {
                let readings = [sensors.angle_rad[index], sensors.acceleration_rad_s2[index] * period_s * period_s];
                for ((at, reading), noise) in observed.into_iter().zip(readings).zip(self.noise) {
                    let variance = covariance[(at, at)] + noise;
                    let innovation = reading - state[at];
                    likelihood -= 0.5 * (variance.ln() + innovation * innovation / variance);
                    let gain = covariance.column(at) / variance;
                    state += gain * innovation;
                    covariance -= gain * gain.transpose() * variance;
                }
            }
            steps.push(Step { predicted, predicted_covariance, filtered: state, covariance });
        }
        likelihood
    }
}

/// The filter whose innovations are likeliest, over half decades of jerk.
fn likeliest(sensors: &Sensors<'_>) -> Filter {
    let length = sensors.angle_rad.len().min(LIKELIHOOD_SAMPLES);
    let noise = Filter::new(sensors, 0.0).noise[1].max(f64::MIN_POSITIVE);
    let mut best: Option<(f64, f64)> = None;
    let mut steps = Vec::with_capacity(length);
    let mut consider = |jerk: f64, best: &mut Option<(f64, f64)>| {
        steps.clear();
        let likelihood = Filter::new(sensors, jerk).run(sensors, length, &mut steps);
        if likelihood.is_finite() && best.is_none_or(|(known, _)| likelihood > known) {
            *best = Some((likelihood, jerk));
        }
    };
    for decade in DECADES {
        consider(noise * 10_f64.powi(decade), &mut best);
    }
    let coarse = best.map_or(noise, |(_, jerk)| jerk);
    for share in [0.316, 3.16] {
        consider(coarse * share, &mut best);
    }
    Filter::new(sensors, best.map_or(noise, |(_, jerk)| jerk))
}
