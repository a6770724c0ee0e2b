//! Rigid axes as other people log them: slowly, coarsely, or moved in one way only. Nothing is missing there, and no effect is invented.

use std::f64::consts::TAU;

use crate::common::{Capture, Uniform};
use identification::diagnosis::{DiagnoseOptions, Diagnosis, Verdict, diagnose};
use identification::{Fit, FitOptions, fit};

const INERTIA: f64 = 0.35;
const COULOMB_MNM: f64 = 5.6;
const VISCOUS: f64 = 0.3;
const DURATION_S: f64 = 12.0;

/// Angle, velocity and acceleration at a time.
type Motion = fn(f64) -> [f64; 3];

/// A logger: its rate, the steps of its encoder, and the noise of its torque.
#[derive(Clone, Copy)]
struct Logger {
    rate_hz: f64,
    bits: u32,
    noise_mnm: f64,
}

/// Sinusoids with these frequencies (Hz) and amplitudes (rad).
fn sinusoids<const COUNT: usize>(t_s: f64, of: [(f64, f64); COUNT]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (hz, rad) in of {
        let turning = TAU * hz;
        let (sine, cosine) = (turning * t_s + hz * hz).sin_cos();
        for (slot, value) in sum.iter_mut().zip([sine, turning * cosine, -turning * turning * sine]) {
            *slot += rad * value;
        }
    }
    sum
}

fn multisine(t_s: f64) -> [f64; 3] {
    sinusoids(t_s, [(0.5, 1.0), (1.1, 0.3), (2.3, 0.15), (3.9, 0.08)])
}

fn other_multisine(t_s: f64) -> [f64; 3] {
    sinusoids(t_s, [(0.4, 1.0), (1.3, 0.35), (2.9, 0.12), (4.7, 0.06)])
}

/// There and back at one speed, with turns of a twentieth of a second.
fn triangle(t_s: f64) -> [f64; 3] {
    const SPEED_RAD_S: f64 = 3.0;
    const TURN_S: f64 = 0.05;
    const PERIOD_S: f64 = 2.0;
    // The trapezoid of velocity and its integral, from the middle of a turn on.
    let within = (t_s / PERIOD_S).fract() * PERIOD_S;
    let (half, place) = ((within / (0.5 * PERIOD_S)).floor(), within % (0.5 * PERIOD_S));
    let sign = if half == 0.0 { 1.0 } else { -1.0 };
    let rate = 2.0 * SPEED_RAD_S / TURN_S;
    let rise = 0.5 * TURN_S;
    let (velocity, acceleration, travelled) = if place < rise {
        (rate * place, rate, 0.5 * rate * place * place)
    } else if place < 0.5 * PERIOD_S - rise {
        (SPEED_RAD_S, 0.0, SPEED_RAD_S * (place - 0.5 * rise))
    } else {
        let left = 0.5 * PERIOD_S - place;
        (rate * left, -rate, SPEED_RAD_S * (0.5 * PERIOD_S - rise) - 0.5 * rate * left * left)
    };
    let whole = SPEED_RAD_S * (0.5 * PERIOD_S - rise);
    [if half == 0.0 { travelled } else { whole - travelled }, sign * velocity, sign * acceleration]
}

/// A capture of the axis under a constant torque besides.
fn captured(seed: u64, logger: Logger, motion: Motion, constant_mnm: f64) -> Capture {
    let mut random = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let step_rad = TAU / f64::from(1 << logger.bits);
    let mut capture = Capture::default();
    for sample in 0..(DURATION_S * logger.rate_hz) as u32 {
        let t_s = f64::from(sample) / logger.rate_hz;
        let [angle_rad, velocity_rad_s, acceleration_rad_s2] = motion(t_s);
        let friction_mnm = COULOMB_MNM * velocity_rad_s.signum() + VISCOUS * velocity_rad_s;
        let noise_mnm = logger.noise_mnm * random.normal();
        capture.t_s.push(t_s);
        capture.angle_rad.push((angle_rad / step_rad).round() * step_rad);
        capture.torque_mnm.push(INERTIA * acceleration_rad_s2 + friction_mnm + constant_mnm + noise_mnm);
    }
    capture
}

/// A capture of the axis under a torque without a servo: tones of these frequencies (Hz), at whose turning points it sticks.
fn driven(seed: u64, logger: Logger, tones_hz: &[f64]) -> Capture {
    const TONE_MNM: f64 = 7.0;
    const STEPS_PER_SAMPLE: u32 = 20;
    let mut random = Uniform(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
    let step_rad = TAU / f64::from(1 << logger.bits);
    let step_s = 1.0 / (logger.rate_hz * f64::from(STEPS_PER_SAMPLE));
    let (mut angle_rad, mut velocity_rad_s) = (0.0, 0.0_f64);
    let mut capture = Capture::default();
    for step in 0..(DURATION_S / step_s) as u32 {
        let t_s = f64::from(step) * step_s;
        let torque_mnm = tones_hz.iter().map(|hz| TONE_MNM * (TAU * hz * t_s + hz * hz).sin()).sum::<f64>();
        if step % STEPS_PER_SAMPLE == 0 {
            capture.t_s.push(t_s);
            capture.angle_rad.push((angle_rad / step_rad).round() * step_rad);
            capture.torque_mnm.push(torque_mnm + logger.noise_mnm * random.normal());
        }
        let left_mnm = torque_mnm - VISCOUS * velocity_rad_s;
        if velocity_rad_s == 0.0 && left_mnm.abs() <= COULOMB_MNM {
            continue;
        }
        let sign = if velocity_rad_s == 0.0 { left_mnm.signum() } else { velocity_rad_s.signum() };
        let next_rad_s = velocity_rad_s + step_s * (left_mnm - COULOMB_MNM * sign) / INERTIA;
        velocity_rad_s = if velocity_rad_s * next_rad_s < 0.0 { 0.0 } else { next_rad_s };
        angle_rad += step_s * velocity_rad_s;
    }
    capture
}

fn diagnosed(logger: Logger, [train, heldout]: [Motion; 2]) -> Diagnosis {
    diagnosed_of([(1, train), (2, heldout)].map(|(seed, motion)| captured(seed, logger, motion, 0.0)))
}

fn diagnosed_of([train, heldout]: [Capture; 2]) -> Diagnosis {
    diagnose(&train.samples(), Some(&heldout.samples()), &DiagnoseOptions::default()).unwrap()
}

fn fitted(capture: &Capture) -> Fit {
    fit(&capture.samples(), &FitOptions::default()).unwrap()
}

#[test]
fn white_noise_of_the_torque_is_no_shaft() {
    let found = diagnosed(Logger { rate_hz: 2000.0, bits: 20, noise_mnm: 0.6 }, [multisine, other_multisine]);
    assert_eq!((found.verdict, found.effects), (Verdict::None, Vec::new()), "{}", found.summary);
}

#[test]
fn a_drive_that_goes_on_while_the_axis_sticks_is_no_noise_and_no_shaft() {
    let logger = Logger { rate_hz: 1000.0, bits: 16, noise_mnm: 0.1 };
    let found = diagnosed_of([driven(1, logger, &[0.3, 0.7, 1.3, 2.1]), driven(2, logger, &[0.4, 0.9, 1.7])]);
    assert_eq!((found.verdict, found.effects), (Verdict::None, Vec::new()), "{}", found.summary);
    let over_floor = found.heldout_rms_before / found.noise_floor_rms;
    assert!(over_floor > 0.8, "the floor is {:.1} times what the model leaves", 1.0 / over_floor);
}

#[test]
fn a_reversal_between_two_samples_is_no_effect() {
    for rate_hz in [100.0, 250.0] {
        let found = diagnosed(Logger { rate_hz, bits: 17, noise_mnm: 0.1 }, [multisine, other_multisine]);
        assert_eq!((found.verdict, found.effects), (Verdict::None, Vec::new()), "{rate_hz} Hz: {}", found.summary);
    }
}

#[test]
fn what_one_speed_does_not_show_is_no_effect_at_others() {
    let found = diagnosed(Logger { rate_hz: 500.0, bits: 16, noise_mnm: 0.1 }, [triangle, multisine]);
    assert_eq!(found.effects, Vec::<&str>::new(), "{}", found.summary);
    let is_told = |note: &String| note.contains("does not determine");
    assert!(found.notes.iter().any(is_told), "{:?}", found.notes);
}

#[test]
fn friction_beside_a_large_constant_torque_is_known_in_sum_alone() {
    let logger = Logger { rate_hz: 1000.0, bits: 17, noise_mnm: 0.1 };
    let fit = fitted(&captured(3, logger, multisine, 3.0 * COULOMB_MNM));
    for name in ["coulomb_negative", "coulomb_positive"] {
        let parameter = fit.parameters.get(name).unwrap();
        assert!(parameter.value.is_none(), "{name} {parameter:?}");
        let sum = format!("add up to {:.0}", 2.0 * COULOMB_MNM);
        assert!(parameter.reason.as_ref().unwrap().contains(&sum), "{sum}: {parameter:?}");
    }
    let fit = fitted(&captured(4, logger, multisine, 0.5 * COULOMB_MNM));
    assert!(fit.notes.iter().any(|note| note.contains("a constant torque")), "{:?}", fit.notes);
}

#[test]
fn a_long_delay_of_the_torque_widens_the_intervals() {
    let capture = captured(5, Logger { rate_hz: 1000.0, bits: 17, noise_mnm: 0.1 }, multisine, 0.0);
    let mut late = capture.clone();
    // 6 ms.
    late.torque_mnm.rotate_right(6);
    let half = |fit: &Fit, name: &str| {
        let [low, high] = fit.parameters.get(name).and_then(|parameter| parameter.ci95).unwrap();
        0.5 * (high - low)
    };
    let [in_time, late] = [&capture, &late].map(fitted);
    for (name, truth) in [("inertia", INERTIA), ("viscous_positive", VISCOUS), ("viscous_negative", VISCOUS)] {
        let [low, high] = late.parameters.get(name).and_then(|parameter| parameter.ci95).unwrap();
        assert!((low..=high).contains(&truth), "{name} of {truth}: [{low}, {high}]");
        assert!(half(&late, name) > half(&in_time, name), "{name}");
    }
}

#[test]
fn a_delay_beside_a_weight_far_heavier_than_the_noise_is_found() {
    const WEIGHT_MNM: f64 = 60.0;
    let late = |seed, motion: Motion| {
        let mut capture = captured(seed, Logger { rate_hz: 1000.0, bits: 17, noise_mnm: 0.1 }, motion, 0.0);
        for (torque_mnm, angle_rad) in capture.torque_mnm.iter_mut().zip(&capture.angle_rad) {
            *torque_mnm += WEIGHT_MNM * (angle_rad - 0.4).sin();
        }
        // 3 ms.
        capture.torque_mnm.rotate_right(3);
        capture
    };
    let found = diagnosed_of([late(6, multisine), late(7, other_multisine)]);
    assert_eq!(found.effects, ["mass-imbalance", "sensor-delay"], "{}", found.summary);
    let [low, high] = found.steps[1].parameters["sensor_delay"].ci95.unwrap();
    assert!(low > 2.7e-3 && high < 3.3e-3, "{low} to {high}");
}
