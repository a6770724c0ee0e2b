//! What varies once over the travel is no detent; detents of which the travel holds a few periods are.
//!
//! The plant is written out here: a torque by formula over a motion by formula, both sampled with noise.

use std::f64::consts::TAU;

use crate::common::{Capture, Uniform};
use identification::{Fit, FitOptions, fit};

/// Captures of each sort.
const SEEDS: u64 = 60;
const RATE_HZ: f64 = 2000.0;
const SAMPLES: u32 = 12_000;

/// A motion of a few sines that travels `travel_rad` about `middle_rad`.
struct Motion {
    middle_rad: f64,
    travel_rad: f64,
    /// Amplitude relative to the sum, rate in rad/s, phase.
    sines: Vec<[f64; 3]>,
}

impl Motion {
    fn of(random: &mut Uniform, travel_rad: f64) -> Self {
        let mut sines: Vec<[f64; 3]> =
            (0..3).map(|_| [0.2 + random.next(), TAU * random.log_between(0.3, 4.0), TAU * random.next()]).collect();
        let sum: f64 = sines.iter().map(|sine| sine[0]).sum();
        sines.iter_mut().for_each(|sine| sine[0] /= sum);
        Self { middle_rad: 6.0 * random.next() - 3.0, travel_rad, sines }
    }

    /// Angle, speed and acceleration.
    fn at(&self, time_s: f64) -> [f64; 3] {
        let mut motion = [self.middle_rad, 0.0, 0.0];
        for [share, rate, phase] in &self.sines {
            let (sine, cosine) = (rate * time_s + phase).sin_cos();
            let amplitude = 0.5 * self.travel_rad * share;
            motion[0] += amplitude * sine;
            motion[1] += amplitude * rate * cosine;
            motion[2] -= amplitude * rate * rate * sine;
        }
        motion
    }
}

/// Inertia, friction and `more`, a torque of place (−1 to 1 over the travel), angle and direction in units of Coulomb friction.
fn captured(random: &mut Uniform, motion: &Motion, more: impl Fn(f64, f64, f64) -> f64) -> Capture {
    let (inertia, coulomb, viscous) =
        (random.log_between(0.02, 0.2), random.log_between(2.0, 10.0), random.log_between(0.05, 0.5));
    let (torque_noise, encoder_alone) = (random.log_between(0.01, 0.2) * coulomb, random.next() < 0.5);
    let mut capture = Capture::default();
    let (mut velocity_rad_s, mut acceleration_rad_s2) = (Vec::new(), Vec::new());
    for sample in 0..SAMPLES {
        let time_s = f64::from(sample) / RATE_HZ;
        let [angle, velocity, acceleration] = motion.at(time_s);
        let place = (angle - motion.middle_rad) / (0.5 * motion.travel_rad);
        let torque = inertia * acceleration
            + coulomb * velocity.signum()
            + viscous * velocity
            + coulomb * more(place, angle, velocity.signum());
        capture.t_s.push(time_s);
        capture.angle_rad.push(angle + if encoder_alone { 1e-5 * random.normal() } else { 0.0 });
        velocity_rad_s.push(velocity);
        acceleration_rad_s2.push(acceleration);
        capture.torque_mnm.push(torque + torque_noise * random.normal());
    }
    if !encoder_alone {
        (capture.velocity_rad_s, capture.acceleration_rad_s2) = (Some(velocity_rad_s), Some(acceleration_rad_s2));
    }
    capture
}

fn fitted(capture: &Capture) -> Fit {
    fit(&capture.samples(), &FitOptions::default()).unwrap()
}

fn period_rad(fit: &Fit) -> Option<f64> {
    fit.parameters.get("detent_period").unwrap().value
}

/// Torque of place, angle and direction that is no detent; the seed's own numbers tell which and how much.
fn smooth(sort: u64, random: &mut Uniform, travel_rad: f64) -> Box<dyn Fn(f64, f64, f64) -> f64> {
    let size = random.log_between(0.2, 5.0);
    let [first, second] = [2.0 * random.next() - 1.0, TAU * random.next()];
    let wavelength = 2.0 * travel_rad / (0.5 + random.next());
    let turning = move |angle: f64| (angle + second).sin();
    match sort {
        0 => Box::new(move |place, _, _| size * (place + first)),
        1 => Box::new(move |place, _, _| size * (place + 0.5 * first).powi(3)),
        2 => Box::new(move |place, _, _| size * (place + first).powi(2)),
        3 => Box::new(move |_, angle, _| size * turning(angle)),
        4 => Box::new(move |_, angle, direction| 0.9 * direction * (TAU * angle / wavelength + second).sin()),
        5 => Box::new(move |_, angle, direction| 0.9 * direction * turning(angle)),
        6 => Box::new(move |place, _, _| 3.0 * size * ((place - 0.8).max(0.0) + (place + 0.75).min(0.0))),
        7 => Box::new(move |place, angle, _| size * (place + first + turning(angle))),
        8 => Box::new(move |place, _, _| size * (2.0 * (place + first)).tanh()),
        _ => Box::new(|_, _, _| 0.0),
    }
}

const SORTS: [&str; 10] = [
    "a spring",
    "a spring that stiffens",
    "a bend",
    "gravity",
    "friction that varies over the travel",
    "friction that varies over a turn",
    "soft stops at both ends",
    "a spring and gravity",
    "a spring that softens",
    "nothing",
];

#[test]
fn what_varies_once_over_the_travel_is_no_detent() {
    let mut told = Vec::new();
    for (sort, name) in (0..).zip(SORTS) {
        for seed in 0..SEEDS {
            let mut random = Uniform(0x9e37_79b9_7f4a_7c15 ^ (1000 * sort + seed + 1));
            let travel_rad = random.log_between(0.3, 20.0);
            let motion = Motion::of(&mut random, travel_rad);
            let more = smooth(sort, &mut random, travel_rad);
            let fit = fitted(&captured(&mut random, &motion, more));
            if let Some(period) = period_rad(&fit) {
                told.push(format!(
                    "{name}, seed {seed}: {:.2} periods of {period:.3} rad in {travel_rad:.2} rad",
                    travel_rad / (TAU * period)
                ));
            }
        }
    }
    let tried = SORTS.len() * SEEDS as usize;
    assert!(100 * told.len() <= tried, "{} detents in {tried} captures without: {told:#?}", told.len());
}

#[test]
fn detents_of_which_the_travel_holds_two_or_more_are_found() {
    let mut missed = Vec::new();
    for seed in 0..2 * SEEDS {
        let mut random = Uniform(0x2545_f491_4f6c_dd1d ^ (seed + 1));
        let travel_rad = random.log_between(0.3, 4.0);
        let motion = Motion::of(&mut random, travel_rad);
        let periods = random.log_between(2.0, 12.0);
        let (size, phase) = (random.log_between(0.3, 5.0), TAU * random.next());
        let truth = travel_rad / (TAU * periods);
        let fit = fitted(&captured(&mut random, &motion, move |_, angle, _| size * (angle / truth + phase).sin()));
        let found = period_rad(&fit);
        if found.is_none_or(|found| (found / truth - 1.0).abs() > 0.05) {
            missed.push(format!("seed {seed}: {periods:.2} periods of {truth:.3} rad, told {found:?}"));
        }
    }
    assert!(100 * missed.len() <= 3 * 2 * SEEDS as usize, "{} missed: {missed:#?}", missed.len());
}

#[test]
fn friction_that_falls_with_speed_is_remarked() {
    for seed in 0..10 {
        let mut random = Uniform(0x9e37_79b9_7f4a_7c15 ^ (seed + 1));
        let motion = Motion::of(&mut random, 3.0);
        let mut capture = captured(&mut random, &motion, |_, _, _| 0.0);
        let remarked = |fit: &Fit| fit.notes.iter().any(|note| note.contains("viscous") && note.contains("negative"));
        assert!(!remarked(&fitted(&capture)), "seed {seed}: a remark on friction that rises");
        for (sample, torque) in (0..).zip(&mut capture.torque_mnm) {
            *torque -= 2.0 * motion.at(f64::from(sample) / RATE_HZ)[1];
        }
        assert!(remarked(&fitted(&capture)), "seed {seed}: no remark on friction that falls");
    }
}
