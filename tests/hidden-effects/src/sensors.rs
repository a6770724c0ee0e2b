//! What the sensors make of the rig's course: steps, noise, lag, and the faults of the torque channel.

use biquad::{Biquad, Coefficients, DirectForm2Transposed, ToHertz, Type};

use crate::base_fit::Sample;
use crate::draw::Draw;
use crate::effect::{Effect, between};
use crate::family::{Conditions, Noise, Ring};
use crate::plant::{Course, STEP_S};

/// Step of the accelerometer, rad/s².
const ACCELEROMETER_STEP_RAD_S2: f64 = 2.8;
/// Step of the torque channel, mNm.
const TORQUE_STEP_MNM: f64 = 0.18;

/// The noise of one rig's sensors.
#[derive(Clone, Copy, Debug)]
pub struct Sensors {
    /// RMS of the torque noise before its steps, mNm.
    pub torque_noise_mnm: f64,
    /// RMS of the accelerometer's noise before its steps, rad/s².
    pub acceleration_noise_rad_s2: f64,
    /// Corner of the velocity's causal low-pass, Hz.
    pub velocity_corner_hz: f64,
}

impl Sensors {
    /// Sensors as good as the paper's.
    pub fn draw(draw: &mut Draw, rate_hz: f64) -> Self {
        Self {
            torque_noise_mnm: draw.uniform(0.2, 0.57),
            acceleration_noise_rad_s2: draw.uniform(1.0, 2.0),
            velocity_corner_hz: draw.uniform(600.0, 1000.0).min(0.4 * rate_hz),
        }
    }

    /// RMS of the torque noise, its steps included, mNm.
    pub fn torque_noise_rms_mnm(&self) -> f64 {
        self.torque_noise_mnm.hypot(TORQUE_STEP_MNM / 12_f64.sqrt())
    }
}

/// The recorded columns of one capture.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Encoder, rad.
    pub angle_rad: Vec<f64>,
    /// Encoder differentiated and low-passed, rad/s; empty where it is not logged.
    pub velocity_rad_s: Vec<f64>,
    /// Accelerometer, rad/s²; empty where it is not logged.
    pub acceleration_rad_s2: Vec<f64>,
    /// Torque, mNm.
    pub torque_mnm: Vec<f64>,
}

/// Noise-free samples at a rate, with what the effects do to the sensors and nothing of the family's conditions.
pub fn ideal(course: &Course, effects: &[Effect], rate_hz: f64, duration_s: f64) -> Vec<Sample> {
    let torque = torque_channel(&course.torque_mnm, effects, None);
    (0..samples(rate_hz, duration_s)).map(|index| sample(course, &torque, effects, index as f64 / rate_hz)).collect()
}

/// Records a course as the sensors tell it.
pub fn record(
    course: &Course,
    effects: &[Effect],
    sensors: Sensors,
    conditions: &Conditions,
    duration_s: f64,
    draw: &mut Draw,
) -> Record {
    let rate_hz = conditions.rate_hz;
    let torque = torque_channel(&course.torque_mnm, effects, conditions.ring);
    let count = samples(rate_hz, duration_s);
    let mut record = Record::default();
    let mut clean = Vec::with_capacity(count);
    for index in 0..count {
        let tick = index as f64 / rate_hz;
        let true_time = (tick + conditions.jitter / rate_hz * draw.normal()).max(0.0);
        record.time_s.push(if conditions.jitter_is_recorded { true_time } else { tick });
        clean.push(sample(course, &torque, effects, true_time));
    }
    let step_rad = conditions.encoder_step_rad;
    let start = draw.uniform(0.0, step_rad);
    record.angle_rad = clean.iter().map(|s| steps(s.angle_rad - start, step_rad) + start).collect();
    let mut noisy = |value: f64, noise: f64, step: f64| steps(value + noise * draw.normal(), step);
    if !conditions.logs_angle_alone {
        record.velocity_rad_s = lagging_velocity(&record.angle_rad, rate_hz, sensors.velocity_corner_hz);
        record.acceleration_rad_s2 = clean
            .iter()
            .map(|s| noisy(s.acceleration_rad_s2, sensors.acceleration_noise_rad_s2, ACCELEROMETER_STEP_RAD_S2))
            .collect();
    }
    let noise = colour(conditions.noise, count, rate_hz, draw);
    let range = conditions.clipped_share.map_or(f64::INFINITY, |share| range_but(&clean, share));
    record.torque_mnm = clean
        .iter()
        .zip(noise)
        .map(|(s, noise)| s.torque_mnm + sensors.torque_noise_mnm * noise)
        .map(|torque| steps(torque.clamp(-range, range), TORQUE_STEP_MNM))
        .collect();
    record
}

fn samples(rate_hz: f64, duration_s: f64) -> usize {
    (rate_hz * duration_s).round() as usize
}

fn steps(value: f64, step: f64) -> f64 {
    step * (value / step).round()
}

/// The torque that only this share of the samples exceeds, mNm.
fn range_but(samples: &[Sample], share: f64) -> f64 {
    let mut magnitudes: Vec<f64> = samples.iter().map(|s| s.torque_mnm.abs()).collect();
    magnitudes.sort_by(f64::total_cmp);
    let place = ((1.0 - share) * magnitudes.len() as f64) as usize;
    magnitudes.get(place).copied().unwrap_or(f64::INFINITY)
}

/// The state at a time between steps. A step's mean belongs to its middle.
fn sample(course: &Course, torque_mnm: &[f64], effects: &[Effect], time_s: f64) -> Sample {
    let place = time_s / STEP_S;
    let true_angle = between(&course.angle_rad, place);
    let velocity = between(&course.velocity_rad_s, place);
    let (mut angle, mut rate) = (true_angle, 1.0);
    let mut torque = between(torque_mnm, place - 0.5);
    for effect in effects {
        let [more, slope] = effect.acts().encoder(effect.size, true_angle);
        angle += more;
        rate += slope;
        torque = effect.acts().reading(effect.size, torque, time_s);
    }
    Sample {
        angle_rad: angle,
        velocity_rad_s: velocity * rate,
        acceleration_rad_s2: between(&course.acceleration_rad_s2, place - 0.5),
        torque_mnm: torque,
    }
}

/// The torque as the sensor passes it on, step by step: what needs the time between samples.
fn torque_channel(torque_mnm: &[f64], effects: &[Effect], ring: Option<Ring>) -> Vec<f64> {
    let mut passed = torque_mnm.to_vec();
    for effect in effects {
        effect.acts().channel(effect.size, &mut passed);
    }
    if let Some(Ring { frequency_hz, damping }) = ring {
        let speed = std::f64::consts::TAU * frequency_hz;
        let (mut reading, mut rate) = (passed[0], 0.0);
        for torque in &mut passed {
            rate += STEP_S * (speed * speed * (*torque - reading) - 2.0 * damping * speed * rate);
            reading += STEP_S * rate;
            *torque = reading;
        }
    }
    passed
}

/// The encoder's angle differentiated backwards and low-passed by a causal Butterworth filter of fourth order.
fn lagging_velocity(angle_rad: &[f64], rate_hz: f64, corner_hz: f64) -> Vec<f64> {
    // The two pole pairs' quality factors: 1 / (2 cos(π/8)) and 1 / (2 cos(3π/8)).
    let sections = [1.0, 3.0].map(|odd| 0.5 / (odd * std::f64::consts::PI / 8.0).cos());
    let mut sections: Vec<_> = sections
        .into_iter()
        .filter_map(|quality| {
            Coefficients::<f64>::from_params(Type::LowPass, rate_hz.hz(), corner_hz.hz(), quality).ok()
        })
        .map(DirectForm2Transposed::<f64>::new)
        .collect();
    let mut before = angle_rad[0];
    angle_rad
        .iter()
        .map(|angle| {
            let difference = (angle - before) * rate_hz;
            before = *angle;
            sections.iter_mut().fold(difference, |value, section| section.run(value))
        })
        .collect()
}

/// Noise of RMS 1.
fn colour(noise: Noise, count: usize, rate_hz: f64, draw: &mut Draw) -> Vec<f64> {
    let mut white: Vec<f64> = (0..count).map(|_| draw.normal()).collect();
    let coefficients: Vec<f64> = match noise {
        Noise::White => return white,
        Noise::Remembering(coefficient) => vec![coefficient],
        // A sum of first-order processes of equal power, an octave apart, falls as 1/f.
        Noise::Pink => {
            let octaves = (rate_hz / 4.0).log2() as i32;
            (0..octaves).map(|octave| (-std::f64::consts::TAU * f64::from(octave).exp2() / rate_hz).exp()).collect()
        }
    };
    let each = (0.5 / coefficients.len() as f64).sqrt();
    white.iter_mut().for_each(|value| *value *= 0.5_f64.sqrt());
    for coefficient in coefficients {
        let fresh = (1.0 - coefficient * coefficient).sqrt();
        let mut past = draw.normal();
        for value in &mut white {
            past = coefficient * past + fresh * draw.normal();
            *value += each * past;
        }
    }
    white
}
