//! Captures by formula: exact motion, torque with noise.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use dynamics::{Drive, Effect, Excitation, Model, Motion, effects};

use super::{Capture, Uniform};

/// A knob of equation 1: M, C₋, C₊, B₋, B₊, A, P, S.
pub fn knob(values: &[f64; 8]) -> Model {
    let effects = vec![
        Effect::new(&effects::inertia::KIND, &values[..1]),
        Effect::new(&effects::friction::KIND, &values[1..5]),
        Effect::new(&effects::detent::KIND, &values[5..]),
    ];
    Model { effects, ..Model::default() }
}

/// An ideal capture of 30,000 samples at 5 kHz: exact motion, torque plus uniform noise of ±`noise_mnm`.
pub fn ideal(knob: &Model, motion: impl Fn(f64) -> Motion, noise_mnm: f64, random: &mut Uniform) -> Capture {
    let motions: Vec<Motion> = (1..=30_000).map(|n| motion(f64::from(n) / 5000.0)).collect();
    Capture {
        t_s: motions.iter().map(|m| m.time_s).collect(),
        angle_rad: motions.iter().map(|m| m.angle_rad).collect(),
        velocity_rad_s: Some(motions.iter().map(|m| m.velocity_rad_s).collect()),
        acceleration_rad_s2: Some(motions.iter().map(|m| m.acceleration_rad_s2).collect()),
        torque_mnm: motions.iter().map(|m| knob.torque_mnm(m) + 2.0 * noise_mnm * (random.next() - 0.5)).collect(),
        calibration: None,
    }
}

/// The motion of a position sweep.
pub fn sweep(name: &str) -> impl Fn(f64) -> Motion {
    let sweep = Excitation::named(name, Drive::Position).unwrap();
    move |time_s| {
        let set = sweep.at(time_s);
        Motion { time_s, angle_rad: set.value, velocity_rad_s: set.rate, acceleration_rad_s2: set.acceleration }
    }
}
