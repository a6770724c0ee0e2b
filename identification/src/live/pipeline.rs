//! Motion and torque of a stream, sample by sample with a fixed lag.

use std::f64::consts::TAU;

use dynamics::{Calibration, Motion};

use super::LiveSample;
use super::blocks::RowFilter;
use crate::numerics::derivative::{GRADIENT_REACH, GRADIENT_WEIGHTS};
use crate::numerics::interpolation::{NEIGHBOURS, cubic_weights};
use crate::numerics::statistics::{MEDIAN_FOURTH_DIFFERENCE, fourth_difference};
use crate::numerics::vector;
use crate::preparation::compliance::compliance_rad_mnm;
use crate::preparation::row_filter::{GUARD_S, SLOW, row_low_pass};

/// The angle's low-pass reaches this much beyond the band in which torque and motion are compared.
const ANGLE_BAND: f64 = 2.5;
/// Speed below which a knob may be sticking, in standard deviations of the velocity's noise; it decides while a sweep is slow.
const NOISE_MARGIN: f64 = 16.0;
/// Relative step of the running median of the encoder's noise.
const MEDIAN_STEP: f64 = 1e-3;

/// Motion and torque at one sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepared {
    pub(super) motion: Motion,
    pub(super) torque_mnm: f64,
    /// Whether the knob surely slides.
    pub(super) is_sliding: bool,
}

/// Smooths and differentiates the angle, aligns the torque, finds stick; all with one fixed lag.
#[derive(Debug)]
pub(super) struct Pipeline {
    rate_hz: f64,
    /// The low-pass of angle and torque, and its taps on either side.
    low_pass: RowFilter,
    half: usize,
    torque_zero_mnm: f64,
    compliance_rad_mnm: f64,
    whole_delay: usize,
    weights: [f64; 4],
    guard: usize,
    count: usize,
    time: Ring,
    angle: Ring,
    received_torque: Ring,
    smooth: Ring,
    smooth_torque: Ring,
    velocity: Ring,
    acceleration: Ring,
    last_slow: usize,
    square_speed: f64,
    speeds: u64,
    noise: f64,
    cutoff_hz: f64,
}

impl Pipeline {
    pub(super) fn new(rate_hz: f64, band_hz: f64, calibration: Option<&Calibration>) -> Self {
        let cutoff_hz = (ANGLE_BAND * band_hz).min(0.4 * rate_hz);
        let fir = row_low_pass(cutoff_hz, rate_hz);
        // A torque ahead of the angle is not corrected, and of a delay beyond 50 ms only 50 ms are.
        let delay = calibration.map_or(0.0, |known| known.torque_delay_s.clamp(0.0, 0.05)) * rate_hz;
        let part = delay.fract();
        let guard = ((GUARD_S + 1.0 / cutoff_hz) * rate_hz).round() as usize;
        let half = fir.half_length();
        let length = 4 * half + 2 * guard + delay as usize + 16;
        let ring = || Ring::new(length);
        Self {
            rate_hz,
            low_pass: RowFilter::new(fir, 1, 2),
            half,
            torque_zero_mnm: calibration.map_or(0.0, |known| known.torque_zero_mnm),
            compliance_rad_mnm: compliance_rad_mnm(calibration),
            whole_delay: delay as usize,
            weights: cubic_weights(NEIGHBOURS, part),
            guard,
            count: 0,
            time: ring(),
            angle: ring(),
            received_torque: ring(),
            smooth: ring(),
            smooth_torque: ring(),
            velocity: ring(),
            acceleration: ring(),
            last_slow: 0,
            square_speed: 0.0,
            speeds: 0,
            noise: 0.0,
            cutoff_hz,
        }
    }

    /// Starts afresh after a gap: the lag must fill again.
    pub(super) fn restart(&mut self) {
        self.count = 0;
        self.last_slow = 0;
    }

    /// A speed below which the knob turns in about a tenth of the time, rad/s.
    pub(super) fn slow_rad_s(&self) -> f64 {
        0.15 * (self.square_speed / self.speeds.max(1) as f64).sqrt()
    }

    /// Takes the next sample; returns the one that lies the fixed lag back, once there is one.
    pub(super) fn push(&mut self, sample: &LiveSample) -> Option<Prepared> {
        let newest = self.count;
        self.count += 1;
        self.time.set(newest, sample.time_s);
        self.angle.set(newest, sample.angle_rad);
        self.received_torque.set(newest, sample.torque_mnm - self.torque_zero_mnm);
        self.learn_noise(newest);
        let aligned = newest.checked_sub(self.whole_delay + 2)?;
        let aligned_sample = self.aligned(aligned);
        // The torque passes the same filter: ringing beyond the cutoff must not remain in only one of the two.
        let &[smooth, torque] = self.low_pass.push(&aligned_sample, true)? else { return None };
        let half = self.half;
        let middle = aligned.checked_sub(2 * half)? + half;
        self.smooth.set(middle, smooth);
        self.smooth_torque.set(middle, torque);
        // The first smoothed angle is at half + 1, as the alignment needs one sample before; each derivative needs some on either side.
        let first = half + 1 + GRADIENT_REACH;
        let now = middle.checked_sub(GRADIENT_REACH).filter(|now| *now >= first)?;
        self.differentiate(now);
        let first = first + GRADIENT_REACH;
        let settled = now.checked_sub(GRADIENT_REACH).filter(|settled| *settled >= first)?;
        self.acceleration.set(settled, self.velocity.gradient(settled, self.rate_hz));
        let out = settled.checked_sub(self.guard).filter(|out| *out >= first + self.guard)?;
        Some(Prepared {
            motion: Motion {
                time_s: self.time.get(out),
                angle_rad: self.smooth.get(out),
                velocity_rad_s: self.velocity.get(out),
                acceleration_rad_s2: self.acceleration.get(out),
            },
            torque_mnm: self.smooth_torque.get(out),
            is_sliding: self.last_slow + self.guard < out,
        })
    }

    /// The knob's angle behind the twist of the sensor, and the torque at the moment of the encoder's reading.
    fn aligned(&self, index: usize) -> [f64; 2] {
        let first = (index + self.whole_delay).saturating_sub(1);
        let torque: f64 =
            self.weights.iter().zip(first..).map(|(weight, at)| weight * self.received_torque.get(at)).sum();
        [self.angle.get(index) - torque * self.compliance_rad_mnm, torque]
    }

    fn differentiate(&mut self, now: usize) {
        let velocity = self.smooth.gradient(now, self.rate_hz);
        self.velocity.set(now, velocity);
        self.square_speed += velocity * velocity;
        self.speeds += 1;
        let rms = (self.square_speed / self.speeds as f64).sqrt();
        if velocity.abs() <= (SLOW * rms).max(NOISE_MARGIN * self.velocity_noise_rad_s()) {
            self.last_slow = now;
        }
    }

    /// White noise of the encoder, differentiated, up to the cutoff.
    fn velocity_noise_rad_s(&self) -> f64 {
        let angle = self.noise / MEDIAN_FOURTH_DIFFERENCE;
        angle * TAU * (self.cutoff_hz.powi(3) / (1.5 * self.rate_hz)).sqrt()
    }

    fn learn_noise(&mut self, newest: usize) {
        if newest < 4 {
            return;
        }
        let fourth = fourth_difference(&[0, 1, 2, 3, 4].map(|back| self.angle.get(newest - back))).abs();
        if fourth == 0.0 {
            return;
        }
        self.noise = if self.noise == 0.0 {
            fourth
        } else if fourth > self.noise {
            self.noise * (1.0 + MEDIAN_STEP)
        } else {
            self.noise / (1.0 + MEDIAN_STEP)
        };
    }
}

/// The last values of a stream, by their index since its start.
#[derive(Clone, Debug)]
struct Ring {
    values: Vec<f64>,
}

impl Ring {
    /// Room for at least `length` values.
    fn new(length: usize) -> Self {
        Self { values: vec![0.0; length.next_power_of_two()] }
    }

    fn set(&mut self, index: usize, value: f64) {
        let place = index & (self.values.len() - 1);
        self.values[place] = value;
    }

    fn get(&self, index: usize) -> f64 {
        self.values[index & (self.values.len() - 1)]
    }

    /// Derivative per second, as the fit of a whole capture takes it.
    fn gradient(&self, index: usize, rate_hz: f64) -> f64 {
        let near = std::array::from_fn(|place| self.get(index + place - GRADIENT_REACH));
        rate_hz * vector::difference(&near, GRADIENT_WEIGHTS)
    }
}
