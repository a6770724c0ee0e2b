//! Captures for tests: ideal ones by formula, and ones from the simulated rig.
#![allow(dead_code, reason = "each test file uses its part")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use dynamics::{Calibration, Drive, Effect, Excitation, Model, Motion, effects, knobs};
use hal::Apparatus;
use hal::simulated::{RigParameters, SimulatedRig};
use identification::Samples;

/// A capture's columns.
#[derive(Clone, Default)]
pub struct Capture {
    pub t_s: Vec<f64>,
    pub angle_rad: Vec<f64>,
    pub velocity_rad_s: Option<Vec<f64>>,
    pub acceleration_rad_s2: Option<Vec<f64>>,
    pub torque_mnm: Vec<f64>,
    pub calibration: Option<Calibration>,
}

impl Capture {
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: self.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.torque_mnm,
        }
    }
}

/// xorshift64*: uniform numbers in [0, 1).
pub struct Uniform(pub u64);

impl Uniform {
    #[allow(clippy::cast_precision_loss, reason = "53 random bits")]
    pub fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A knob of equation 1: M, C₋, C₊, B₋, B₊, A, P, S.
pub fn knob(values: &[f64; 8]) -> Model {
    let effects = vec![
        Effect::new(&effects::inertia::KIND, &values[..1]),
        Effect::new(&effects::friction::KIND, &values[1..5]),
        Effect::new(&effects::detent::KIND, &values[5..]),
    ];
    Model { name: String::new(), description: String::new(), effects }
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

/// Ten seconds of a paper's knob on the simulated rig at 10 kHz, a PD servo following the linear chirp.
pub fn rig(number: u32, seed: u64) -> Capture {
    const RATE_HZ: f64 = 10_000.0;
    let mut rig = SimulatedRig::new(RigParameters::default(), knobs::paper_knob(number).unwrap(), seed).unwrap();
    let calibration = rig.description().calibration.clone();
    let sweep = Excitation::named("linear-chirp", Drive::Position).unwrap();
    rig.enable().unwrap();
    let inertia = calibration.motor_inertia + calibration.gripper_inertia;
    let (mut previous, mut velocity) = (0.0, 0.0);
    let mut acceleration_rad_s2 = Vec::new();
    let mut capture = Capture { calibration: Some(calibration), ..Capture::default() };
    for tick in 0..100_000_u32 {
        let time_s = f64::from(tick) / RATE_HZ;
        let measured = rig.read(u64::from(tick) * 100_000).unwrap();
        let set = sweep.at(time_s);
        velocity += 0.3 * ((measured.angle_rad - previous) * RATE_HZ - velocity);
        previous = measured.angle_rad;
        let servo = 3000.0 * (set.value - measured.angle_rad) + 20.0 * (set.rate - velocity);
        rig.write_torque(inertia * set.acceleration + servo).unwrap();
        capture.t_s.push(time_s);
        capture.angle_rad.push(measured.angle_rad);
        acceleration_rad_s2.push(measured.acceleration_rad_s2);
        capture.torque_mnm.push(measured.torque_mnm);
    }
    Capture { acceleration_rad_s2: Some(acceleration_rad_s2), ..capture }
}

/// The columns of a recording made by others, or `None` where it is not at hand, which is said.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
pub fn measured(file: &str) -> Option<Vec<Vec<f64>>> {
    let folder = std::env::var_os("HAPTIC_CAMERA_DATA").map_or_else(
        || std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"),
        std::path::PathBuf::from,
    );
    let path = folder.join("measured").join(file);
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: there is no {}; HAPTIC_CAMERA_DATA may name the folder", path.display());
        return None;
    };
    let rows: Vec<Vec<f64>> =
        text.lines().skip(1).map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect();
    Some((0..rows[0].len()).map(|column| rows.iter().map(|row| row[column]).collect()).collect())
}
