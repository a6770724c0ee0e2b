//! A sensor at the end of its range, or one that stands still, is said, and what can still be told is told.

use crate::common::{Capture, Uniform, ideal, knob, run, sweep};
use dynamics::{Calibration, Drive, knobs};
use identification::{Fit, FitError, FitOptions, Samples, fit};

/// Ten seconds of a paper's knob that follows the linear chirp on the simulated rig.
fn rig(number: u32, seed: u64) -> Capture {
    run(&knobs::paper_knob(number).unwrap(), "linear-chirp", Drive::Position, None, 10.0, seed)
}

const KNOB: [f64; 8] = [0.1, 3.0, 4.0, 0.5, 0.6, 2.0, 0.05, 0.3];

/// Torque in the steps of 0.18 mNm that a converter makes, motion in the encoder's.
fn digitised(seed: u64) -> Capture {
    let mut capture = ideal(&knob(&KNOB), sweep("linear-chirp"), 0.5, &mut Uniform(seed));
    capture.velocity_rad_s = None;
    capture.acceleration_rad_s2 = None;
    capture.torque_mnm.iter_mut().for_each(|torque| *torque = (*torque / 0.18).round() * 0.18);
    capture.angle_rad.iter_mut().for_each(|angle| *angle = (*angle / 9.8e-6).round() * 9.8e-6);
    capture
}

fn assert_told(fit: &Fit, tolerance: f64, case: &str) {
    for (name, truth) in
        [("inertia", 0.1), ("coulomb_negative", 3.0), ("coulomb_positive", 4.0), ("detent_amplitude", 2.0)]
    {
        let value = fit.parameters.get(name).unwrap().value.unwrap();
        assert!((value / truth - 1.0).abs() < tolerance, "{case}: {name} is {value}");
    }
}

fn note(fit: &Fit, words: &str) -> Option<String> {
    fit.notes.iter().find(|note| note.contains(words)).cloned()
}

#[test]
fn a_torque_sensor_at_its_rails_is_said_and_its_stretches_are_left_out() {
    for seed in 1..=10 {
        let whole = digitised(seed);
        let largest = whole.torque_mnm.iter().copied().fold(0.0, f64::max);
        for (low, high, words) in [
            (-0.6, 0.6, "both ends of its range"),
            (-9.0, 0.6, "the upper end of its range"),
            (-0.6, 9.0, "the lower end of its range"),
        ] {
            let mut capture = whole.clone();
            capture.torque_mnm.iter_mut().for_each(|torque| *torque = torque.clamp(low * largest, high * largest));
            let clipped = capture.torque_mnm.iter().zip(&whole.torque_mnm).filter(|(a, b)| a != b).count();
            let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
            let note = note(&fit, words).unwrap();
            let said: f64 = note.split(" for ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
            // Single visits to the rail, made by noise at the edge of a stretch, are not counted.
            assert!((said / clipped as f64 - 1.0).abs() < 0.1, "seed {seed}: {clipped} clipped, said {said}");
            assert_told(&fit, 0.03, words);
        }
    }
}

#[test]
fn a_sound_torque_sensor_is_not_called_saturated() {
    for seed in 1..=20 {
        let fit = fit(&digitised(seed).samples(), &FitOptions::default()).unwrap();
        assert_eq!(note(&fit, "range"), None, "seed {seed}");
        assert_eq!(note(&fit, "stands still"), None, "seed {seed}");
    }
    for number in 1..=4 {
        let capture = rig(number, 7);
        let options = FitOptions { calibration: capture.calibration.clone(), ..FitOptions::default() };
        let fit = fit(&capture.samples(), &options).unwrap();
        assert_eq!(note(&fit, "range"), None, "knob {number}");
        assert_eq!(note(&fit, "stands still"), None, "knob {number}");
    }
}

#[test]
fn an_accelerometer_at_its_rails_leaves_the_acceleration_to_the_encoder() {
    let mut capture = rig(3, 5);
    let truth = dynamics::knobs::paper_knob(3).unwrap().parameter("inertia").unwrap();
    let acceleration = capture.acceleration_rad_s2.as_mut().unwrap();
    let largest = acceleration.iter().copied().fold(0.0, f64::max);
    acceleration.iter_mut().for_each(|value| *value = value.clamp(-0.3 * largest, 0.3 * largest));
    let options = FitOptions { calibration: capture.calibration.clone(), ..FitOptions::default() };
    let fit = fit(&capture.samples(), &options).unwrap();
    assert!(note(&fit, "acceleration channel stands at an end of its range").is_some(), "{:?}", fit.notes);
    assert!(!fit.preparation.accelerometer);
    assert!((fit.parameters.get("inertia").unwrap().value.unwrap() / truth - 1.0).abs() < 0.02);
}

#[test]
fn an_encoder_that_stands_still_while_the_knob_turns_is_said_and_left_out() {
    for seed in 1..=10 {
        let mut capture = digitised(seed);
        // 40 ms at speed.
        let start = 20_000 + 317 * usize::try_from(seed).unwrap();
        let stuck = capture.angle_rad[start];
        capture.angle_rad[start..start + 200].fill(stuck);
        let moved = (capture.angle_rad[start + 200] - stuck).abs();
        let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
        // Near a reversal the angle hardly changes meanwhile, and nothing is lost.
        if moved > 0.02 {
            assert!(note(&fit, "the angle stands still for 200 samples").is_some(), "seed {seed}: {:?}", fit.notes);
        }
        assert_told(&fit, 0.03, "frozen encoder");
    }
}

#[test]
fn a_torque_sensor_mostly_at_its_rails_serves_for_no_fit() {
    let mut capture = digitised(1);
    capture.torque_mnm.iter_mut().for_each(|torque| *torque = torque.clamp(-0.36, 0.36));
    let error = fit(&capture.samples(), &FitOptions::default()).err().unwrap();
    assert!(matches!(error, FitError::Saturated { .. }), "{error}");
    assert!(error.to_string().contains("wider range"));
}

#[test]
fn a_single_detent_crossed_is_not_called_a_detent() {
    // The travel of 0.3 rad holds one period of 2π·0.05 rad.
    let small = |time_s: f64| {
        let set = sweep("linear-chirp")(time_s);
        dynamics::Motion {
            time_s,
            angle_rad: 0.15 * set.angle_rad,
            velocity_rad_s: 0.15 * set.velocity_rad_s,
            acceleration_rad_s2: 0.15 * set.acceleration_rad_s2,
        }
    };
    let capture = ideal(&knob(&KNOB), small, 0.5, &mut Uniform(3));
    let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
    let period = fit.parameters.get("detent_period").unwrap();
    match (period.value, &period.reason) {
        // The torque of one detent crossed is a whole sinusoid: where it is told, it is told rightly.
        (Some(value), _) => assert!((value / 0.05 - 1.0).abs() < 0.1, "{value}"),
        (None, reason) => assert!(reason.as_ref().is_some_and(|reason| reason.contains("travel")), "{reason:?}"),
    }
    assert!(fit.parameters.get("inertia").unwrap().value.is_some());
}

#[test]
fn a_gap_in_time_is_said() {
    let whole = digitised(4);
    let keep = |column: &[f64]| [&column[..12_000], &column[15_000..]].concat();
    let (t_s, angle, torque) = (keep(&whole.t_s), keep(&whole.angle_rad), keep(&whole.torque_mnm));
    let samples =
        Samples { t_s: &t_s, angle_rad: &angle, velocity_rad_s: None, acceleration_rad_s2: None, torque_mnm: &torque };
    let fit = fit(&samples, &FitOptions::default()).unwrap();
    assert!(note(&fit, "samples missing from the capture").is_some());
    assert_told(&fit, 0.03, "gap");
}

#[test]
fn a_coarse_encoder_that_the_calibration_does_not_know_of_is_said_with_its_step() {
    let mut capture = rig(3, 6);
    capture.angle_rad.iter_mut().for_each(|angle| *angle = (*angle / 1.5e-3).round() * 1.5e-3);
    let noted =
        |capture: &Capture| note(&fit(&capture.samples(), &capture.options()).unwrap(), "`angle_step_rad = 1.50e-3`");
    assert!(noted(&capture).is_none());
    capture.calibration.as_mut().unwrap().angle_step_rad = 0.0;
    assert!(noted(&capture).is_some());
}

#[test]
fn a_torque_sensor_of_the_wrong_sign_is_said_and_one_of_the_right_sign_is_not() {
    for (number, seed) in [(1, 3), (3, 4), (4, 5)] {
        let mut capture = rig(number, seed);
        let right = fit(&capture.samples(), &FitOptions::default()).unwrap();
        assert_eq!(note(&right, "opposite signs"), None, "knob {number}: {} % left", right.relative_error_percent);
        capture.torque_mnm.iter_mut().for_each(|torque| *torque = -*torque);
        let wrong = fit(&capture.samples(), &FitOptions::default()).unwrap();
        let left = wrong.relative_error_percent;
        assert!(
            note(&wrong, "torque and angle have opposite signs").is_some(),
            "knob {number}: {left} % left, {} % with the right sign",
            right.relative_error_percent
        );
    }
}

#[test]
fn an_encoders_step_that_is_not_the_calibrations_is_said() {
    let capture = digitised(1);
    let rig = rig(3, 1).rig().clone();
    let said = |step_rad| {
        let calibration = Some(Calibration { angle_step_rad: step_rad, ..rig.clone() });
        note(
            &fit(&capture.samples(), &FitOptions { calibration, ..FitOptions::default() }).unwrap(),
            "the encoder's step",
        )
    };
    assert_eq!(said(9.8e-6), None);
    assert!(said(4.9e-6).is_some_and(|note| note.contains("9.80e-6") && note.contains("angle_step_rad")));
}
