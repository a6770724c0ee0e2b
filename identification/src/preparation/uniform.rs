//! One sample rate: a capture's columns on an even grid of time.

use dynamics::{Axis, Calibration};

use super::clock::{GAP, JITTER, between, rounded, typical_step};
use super::outliers::cleaned;
use super::repeated_rows::without_repeated_rows;
use super::sampling::own_readings;
use super::saturation::{Saturation, frozen, frozen_note};
use super::spectrum::Spectrum;
use super::wrapped::unwrapped;
use crate::numerics::interpolation::advance;
use crate::numerics::lag::lagged;
use crate::numerics::statistics::{mean, rms};
use crate::samples::{PickedSamples, Samples};

/// Longest stretch that a gap takes up on the grid, s; the filters forget faster.
const LONGEST_GAP_S: f64 = 0.5;
/// Grid points that gaps may take up together, beyond one for each sample: bursts with pauses would fill memory.
const GAP_POINTS: f64 = 1e5;

/// A capture on an even grid, corrected by the rig's calibration.
#[derive(Clone, Debug)]
pub(crate) struct Uniform {
    pub(crate) rate_hz: f64,
    pub(crate) time_s: Vec<f64>,
    pub(crate) angle_rad: Vec<f64>,
    pub(crate) velocity_rad_s: Option<Vec<f64>>,
    pub(crate) acceleration_rad_s2: Option<Vec<f64>>,
    /// Time constant of the first-order lag that is still in the acceleration, s.
    pub(crate) acceleration_lag_s: f64,
    pub(crate) torque_mnm: Vec<f64>,
    /// The torque as it was received, mNm, and its delay in samples; `None` where there was none to take out.
    received: Option<(Vec<f64>, f64)>,
    /// White density of the torque channel's noise, as the upper end of its spectrum shows it, mNm²/Hz.
    pub(crate) torque_density: f64,
    /// Whether the grid point was measured; false inside gaps, and where a sensor was saturated or frozen.
    pub(crate) present: Vec<bool>,
    /// Samples that are missing in gaps.
    pub(crate) lost: usize,
    /// What is wrong with sensors and samples, a sentence each.
    pub(crate) notes: Vec<String>,
}

impl Uniform {
    /// Places checked samples on a grid of their median period.
    pub(crate) fn of(samples: &Samples<'_>, axis: Axis, calibration: Option<&Calibration>) -> Self {
        let (whole, wraps) = unwrapped(samples.angle_rad, axis).unzip();
        let samples = &Samples { angle_rad: whole.as_deref().unwrap_or(samples.angle_rad), ..*samples };
        let (readings, note) = own_readings(samples).or_else(|| without_repeated_rows(samples)).unzip();
        let samples = &readings.as_ref().map_or(*samples, PickedSamples::samples);
        let ([angle_rad, torque_mnm], outliers) = cleaned(samples);
        let samples = &Samples { angle_rad: &angle_rad, torque_mnm: &torque_mnm, ..*samples };
        let mut uniform = Self::on_grid(samples);
        uniform.leave_out_faults(samples, calibration);
        uniform.notes.extend(wraps.into_iter().chain(note).chain(outliers));
        // Before any interpolation, which would take off the upper end.
        let rate_hz = uniform.rate_hz;
        uniform.torque_density = Spectrum::welch(&uniform.torque_mnm, rate_hz).median(0.35 * rate_hz, 0.5 * rate_hz);
        if let Some(calibration) = calibration {
            uniform.calibrate(calibration);
        }
        uniform
    }

    fn on_grid(samples: &Samples<'_>) -> Self {
        let time = samples.t_s;
        let count = time.len();
        let (typical, is_regular) = typical_step(time);
        if is_regular {
            return Self::of_columns(samples, typical, vec![true; count], <[f64]>::to_vec);
        }
        let steps = time.windows(2).map(|pair| pair[1] - pair[0]);
        let (gaps, regular): (Vec<f64>, Vec<f64>) = steps.partition(|step| *step > GAP * typical);
        let step = rounded(mean(&regular));
        let scatter = rms(&regular.iter().map(|step_s| step_s / step - 1.0).collect::<Vec<f64>>());
        if gaps.is_empty() && scatter < JITTER {
            return Self::of_columns(samples, step, vec![true; count], <[f64]>::to_vec);
        }
        // Long gaps are shortened on the grid, so that a pause does not fill memory.
        let longest_s =
            LONGEST_GAP_S.min((count as f64 + GAP_POINTS) / gaps.len().max(1) as f64 * step).max(GAP * step);
        let mut compressed = Vec::with_capacity(count);
        let mut excess = 0.0;
        compressed.push(0.0);
        for pair in time.windows(2) {
            excess += (pair[1] - pair[0] - longest_s).max(0.0);
            compressed.push(pair[1] - time[0] - excess);
        }
        let length = (compressed[count - 1] / step + 1e-6) as usize + 1;
        // Each grid point, the sample before it, and whether the capture covers it.
        let mut points = Vec::with_capacity(length);
        let mut index = 0;
        for point in 0..length {
            let at = point as f64 * step;
            while index + 2 < count && compressed[index + 1] <= at {
                index += 1;
            }
            let [before, after] = [compressed[index], compressed[index + 1]];
            let at = at.clamp(before, after);
            let is_near = (at - before).min(after - at) < 0.25 * step;
            points.push((at, index, after - before <= GAP * step || is_near));
        }
        let sampled = |column: &[f64]| {
            points.iter().map(|(at, index, _)| between(&compressed, column, *index, *at, step)).collect()
        };
        let missing = gaps.iter().map(|passed| (passed / step).round() as usize - 1).sum();
        let uniform = Self::of_columns(samples, step, points.iter().map(|point| point.2).collect(), sampled);
        Self { lost: missing, ..uniform }
    }

    /// The columns on the grid, each as `sampled` there.
    fn of_columns(
        samples: &Samples<'_>,
        step_s: f64,
        present: Vec<bool>,
        sampled: impl Fn(&[f64]) -> Vec<f64> + Copy,
    ) -> Self {
        Self {
            rate_hz: 1.0 / step_s,
            time_s: sampled(samples.t_s),
            angle_rad: sampled(samples.angle_rad),
            velocity_rad_s: samples.velocity_rad_s.map(sampled),
            acceleration_rad_s2: samples.acceleration_rad_s2.map(sampled),
            acceleration_lag_s: 0.0,
            torque_mnm: sampled(samples.torque_mnm),
            received: None,
            torque_density: 0.0,
            lost: 0,
            present,
            notes: Vec::new(),
        }
    }

    /// Marks samples as not measured where the torque channel is saturated or the encoder frozen, and drops the acceleration if
    /// it is saturated: the encoder measures it too.
    fn leave_out_faults(&mut self, samples: &Samples<'_>, calibration: Option<&Calibration>) {
        let torque = Saturation::of(samples.torque_mnm);
        let frozen = frozen(samples.angle_rad, samples.torque_mnm);
        let delay = calibration.map_or(0.0, |known| known.torque_delay_s.abs()) * self.rate_hz;
        // Interpolation between samples looks at two neighbours besides.
        let margin = 2 + delay.ceil() as usize;
        let mut faulty = vec![false; samples.t_s.len()];
        for run in torque.runs.iter().chain(&frozen) {
            let last = (run.end + margin).min(faulty.len());
            faulty[run.start.saturating_sub(margin)..last].fill(true);
        }
        if faulty.contains(&true) {
            let mut index = 0;
            for (present, time) in self.present.iter_mut().zip(&self.time_s) {
                while index + 1 < faulty.len() && samples.t_s[index] < *time {
                    index += 1;
                }
                *present &= !faulty[index] && !faulty[index.saturating_sub(1)];
            }
        }
        // A jump would look like an encoder full of noise.
        for run in frozen.iter().filter(|run| run.end < samples.t_s.len()) {
            let (start, end) = (samples.t_s[run.start], samples.t_s[run.end]);
            let (from, to) = (samples.angle_rad[run.start], samples.angle_rad[run.end]);
            for (angle, time) in self.angle_rad.iter_mut().zip(&self.time_s) {
                if (start..end).contains(time) {
                    *angle = from + (to - from) * (time - start) / (end - start);
                }
            }
        }
        self.notes.extend(torque.note("torque", "mNm"));
        self.notes.extend(frozen_note(&frozen));
        let acceleration = samples.acceleration_rad_s2.map(Saturation::of).unwrap_or_default();
        if acceleration.samples() > 0 {
            self.acceleration_rad_s2 = None;
            self.notes.push(format!(
                "the acceleration channel stands at an end of its range for {} samples: the acceleration was taken from the encoder instead",
                acceleration.samples()
            ));
        }
    }

    /// The torque as it was received, mNm, and by how many samples that is late.
    pub(crate) fn received_torque(&self) -> (&[f64], f64) {
        self.received.as_ref().map_or((&self.torque_mnm, 0.0), |(received_mnm, delay)| (received_mnm, *delay))
    }

    /// Noise of the torque channel at full rate, if it is white as the upper end of its spectrum says, mNm.
    pub(crate) fn torque_noise_mnm(&self) -> f64 {
        (self.torque_density * 0.5 * self.rate_hz).sqrt()
    }

    /// Takes out zeros, gravity and the channels' delays.
    fn calibrate(&mut self, calibration: &Calibration) {
        for torque in &mut self.torque_mnm {
            *torque -= calibration.torque_zero_mnm;
        }
        let delay = calibration.torque_delay_s * self.rate_hz;
        if delay != 0.0 {
            let prompt = advance(&self.torque_mnm, delay);
            self.received = Some((std::mem::replace(&mut self.torque_mnm, prompt), delay));
        }
        if let Some(acceleration) = &mut self.acceleration_rad_s2 {
            // The sensor's lag stays in for now, and gravity passed it as the motion did.
            let gravity: Vec<f64> = self.angle_rad.iter().map(|angle| calibration.gravity_rad_s2(*angle)).collect();
            let lag = calibration.acceleration_delay_s * self.rate_hz;
            for (value, gravity) in acceleration.iter_mut().zip(&lagged(&gravity, lag)) {
                *value -= calibration.acceleration_zero_rad_s2 + gravity;
            }
            self.acceleration_lag_s = calibration.acceleration_delay_s;
        }
    }
}
