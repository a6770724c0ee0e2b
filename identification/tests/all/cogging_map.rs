//! Captures so slow that only torque against angle and direction can be told.
//!
//! `HAPTIC_CAMERA_DATA` names the folder that holds `measured/`; where there is none the test skips and says so.

use std::f64::consts::TAU;

use crate::common::{Capture, Uniform, measured, run};
use dynamics::{Calibration, Drive, Model, knobs};
use identification::diagnosis::{DiagnoseOptions, Verdict, diagnose};
use identification::{Fit, FitError, FitOptions, Point, Samples, fit};

/// A knob stepped by 0.002 rad with rests, at 1 kHz: friction ±`coulomb`, sinusoids (wavenumber, amplitude, phase).
fn stepped(turns: &[(f64, f64)], coulomb: [f64; 2], sinusoids: &[[f64; 3]], random: &mut Uniform) -> Capture {
    let mut capture = Capture::default();
    let mut time_s = 0.0;
    for (from, to) in turns {
        let steps = ((to - from).abs() / 0.002).round();
        let sign = (to - from).signum();
        let mut step = 0.0;
        while step < steps {
            let angle = from + sign * 0.002 * step;
            let friction = if sign > 0.0 { coulomb[1] } else { -coulomb[0] };
            let detents: f64 =
                sinusoids.iter().map(|[k, amplitude, phase]| amplitude * (k * angle + phase).sin()).sum();
            for _ in 0..3 {
                time_s += 0.001 + if random.next() > 0.8 { 0.01 } else { 0.0 };
                capture.t_s.push(time_s);
                capture.angle_rad.push((angle / 3e-4).round() * 3e-4);
                capture.torque_mnm.push(friction + detents + 4.0 * (random.next() + random.next() - 1.0));
            }
            step += 1.0;
        }
    }
    capture
}

fn value(fit: &Fit, name: &str) -> f64 {
    fit.parameters.get(name).unwrap().value.unwrap()
}

#[test]
fn the_measured_cogging_map_shows_its_ladder_by_itself() {
    let Some(columns) = measured("laas-cogging-map.csv") else { return };
    let samples = Samples {
        t_s: &columns[0],
        angle_rad: &columns[1],
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &columns[3],
    };
    let fit = fit(&samples, &FitOptions::default()).unwrap();
    let harmonics = &fit.detent_harmonics;
    // The authors' map: 72, 18, 12, 24 and 36 periods per turn of 183, 42, 30, 18 and 14; they looked no further than
    // 120 per turn, and left out 144, the first overtone of 72.
    let published: [(f64, f64); 5] = [(72.0, 183.0), (18.0, 42.0), (12.0, 30.0), (24.0, 18.0), (36.0, 14.0)];
    let ladder: Vec<_> = harmonics.iter().filter(|harmonic| harmonic.per_turn <= 120.0).take(5).collect();
    for (harmonic, (per_turn, amplitude)) in ladder.iter().zip(published) {
        assert!((harmonic.per_turn - per_turn).abs() < 1e-12, "{harmonic:?}");
        assert!((harmonic.amplitude_mnm / amplitude - 1.0).abs() < 0.05, "{harmonic:?}");
    }
    assert!(harmonics[4].relative_error_percent.unwrap() <= 18.4);
    assert!(fit.relative_error_percent <= harmonics[4].relative_error_percent.unwrap());
    assert!((harmonics[0].relative_error_percent.unwrap() - 33.1).abs() < 0.1, "with the strongest alone");
    assert!((0.5 * (value(&fit, "coulomb_negative") + value(&fit, "coulomb_positive")) / 52.9 - 1.0).abs() < 0.02);
    assert!((value(&fit, "detent_period") * 72.0 - 1.0).abs() < 1e-12);
    for name in ["inertia", "viscous_negative", "viscous_positive", "static_positive"] {
        let parameter = fit.parameters.get(name).unwrap();
        assert_eq!(parameter.value, None);
        assert!(parameter.reason.as_ref().unwrap().contains("too slowly"), "{name}");
    }
}

#[test]
fn a_stepped_map_tells_exactly_the_sinusoids_that_it_was_made_of() {
    let (mut held, mut told) = (0, 0);
    for seed in 1..=20 {
        let mut random = Uniform(seed * 0x9e37_79b9_7f4a_7c15);
        let mut counts: Vec<f64> = Vec::new();
        while counts.len() < 4 {
            let count = (3.0 + 90.0 * random.next()).floor();
            if !counts.contains(&count) {
                counts.push(count);
            }
        }
        let sinusoids: Vec<[f64; 3]> =
            counts.iter().zip([40.0, 15.0, 8.0, 4.0]).map(|(k, a)| [*k, a, TAU * (random.next() - 0.5)]).collect();
        let capture = stepped(&[(0.0, 6.3), (6.3, 0.0)], [9.0, 11.0], &sinusoids, &mut random);
        let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
        let found: Vec<f64> = fit.detent_harmonics.iter().map(|harmonic| harmonic.per_turn).collect();
        assert_eq!(found, counts, "seed {seed}");
        for (harmonic, [_, amplitude, phase]) in fit.detent_harmonics.iter().zip(&sinusoids) {
            assert!((harmonic.amplitude_mnm / amplitude - 1.0).abs() < 0.05, "seed {seed}: {harmonic:?}");
            assert!((harmonic.phase_rad - phase).sin().abs() < 0.08, "seed {seed}: {harmonic:?}");
            let [low, high] = harmonic.amplitude_ci95_mnm.unwrap();
            told += 1;
            held += i32::from((low..=high).contains(amplitude));
        }
        for (name, truth) in [("coulomb_negative", 9.0), ("coulomb_positive", 11.0)] {
            assert!((value(&fit, name) - truth).abs() < 0.3, "seed {seed}: {name}");
        }
        // The model file holds all of them.
        let model = Model::from_toml(&fit.model("map").to_toml(), "map").unwrap();
        let lost_mnm = |point: &Point| (model.torque_mnm(&point.motion()) - point.torque_model_mnm).abs();
        assert!(fit.points.iter().map(lost_mnm).fold(0.0, f64::max) < 0.05, "seed {seed}");
    }
    // 80 intervals of 95 %: fewer than 68 within would be a chance below one in 10⁴.
    assert!(held >= 68, "{held} of {told} amplitudes lie within their intervals");
}

#[test]
fn rests_wraps_and_a_misread_angle_do_not_change_a_map() {
    let mut random = Uniform(21);
    let plain = stepped(&[(0.0, 6.3), (6.3, 0.0)], [9.0, 11.0], &[[12.0, 20.0, 0.4]], &mut random);
    let mut disturbed = plain.clone();
    // Five seconds in mid-travel, and ten after the motor was switched off.
    let middle = disturbed.t_s.len() / 4;
    let rest = |capture: &mut Capture, at: usize, samples: usize| {
        let (time_s, angle_rad) = (capture.t_s[at - 1], capture.angle_rad[at - 1]);
        let resting = (1..=samples).map(|sample| time_s + 1e-3 * sample as f64);
        capture.t_s[at..].iter_mut().for_each(|time| *time += 1e-3 * samples as f64);
        capture.t_s.splice(at..at, resting);
        capture.angle_rad.splice(at..at, vec![angle_rad; samples]);
        capture.torque_mnm.splice(at..at, (0..samples).map(|sample| 0.1 * (sample as f64).sin()));
    };
    rest(&mut disturbed, middle, 5_000);
    let end = disturbed.t_s.len();
    rest(&mut disturbed, end, 10_000);
    disturbed.angle_rad.iter_mut().for_each(|angle| *angle = (*angle + 2.0).rem_euclid(TAU));
    disturbed.angle_rad[1000] += 1.0;
    let fit = fit(&disturbed.samples(), &FitOptions::default()).unwrap();
    for (name, truth) in [("coulomb_negative", 9.0), ("coulomb_positive", 11.0)] {
        assert!((value(&fit, name) - truth).abs() < 0.3, "{name}: {}", value(&fit, name));
    }
    assert!((value(&fit, "detent_amplitude") / 20.0 - 1.0).abs() < 0.05);
    for words in ["begins anew after a turn", "the angle that stand out from all around them: 1;"] {
        assert!(fit.notes.iter().any(|note| note.contains(words)), "{:?}", fit.notes);
    }
}

#[test]
fn part_of_a_turn_tells_a_wavenumber_that_is_no_whole_number() {
    for seed in 1..=10 {
        let mut random = Uniform(seed * 0x9e37_79b9_7f4a_7c15);
        let wavenumber = 15.0 + 30.0 * random.next();
        let capture = stepped(&[(0.2, 1.9), (1.9, 0.2)], [6.0, 6.0], &[[wavenumber, 20.0, 1.0]], &mut random);
        let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
        assert!((value(&fit, "detent_period") * wavenumber - 1.0).abs() < 2e-3, "seed {seed}");
        assert!((value(&fit, "detent_amplitude") / 20.0 - 1.0).abs() < 0.05, "seed {seed}");
        assert!(fit.notes.iter().any(|note| note.contains("less than a whole turn")));
    }
}

#[test]
fn a_map_of_noise_and_friction_has_no_detents() {
    for seed in 1..=20 {
        let mut random = Uniform(seed * 0x9e37_79b9_7f4a_7c15);
        let capture = stepped(&[(0.0, 6.3), (6.3, 0.0)], [9.0, 11.0], &[], &mut random);
        let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
        assert!(fit.detent_harmonics.is_empty(), "seed {seed}: {:?}", fit.detent_harmonics);
        assert!(fit.parameters.get("detent_amplitude").unwrap().reason.is_some());
        assert!((value(&fit, "coulomb_negative") - 9.0).abs() < 0.3, "seed {seed}");
    }
}

#[test]
fn a_map_in_one_direction_tells_that_direction() {
    let capture = stepped(&[(0.0, 6.3)], [9.0, 11.0], &[[12.0, 20.0, 0.4]], &mut Uniform(11));
    let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
    assert!((value(&fit, "coulomb_positive") - 11.0).abs() < 0.3);
    let negative = fit.parameters.get("coulomb_negative").unwrap();
    assert!(negative.value.is_none() && negative.reason.as_ref().unwrap().contains("negative direction"));
    assert!((value(&fit, "detent_period") * 12.0 - 1.0).abs() < 1e-12);
}

#[test]
fn an_encoder_that_only_trembles_is_no_map() {
    let mut random = Uniform(12);
    let mut capture = stepped(&[(0.0, 6.3)], [9.0, 11.0], &[], &mut random);
    capture.angle_rad.iter_mut().for_each(|angle| *angle = 1e-4 * random.next());
    assert!(matches!(fit(&capture.samples(), &FitOptions::default()), Err(FitError::HardlyMoving { .. })));
}

#[test]
fn a_map_is_diagnosed_by_what_depends_on_the_angle() {
    let mut random = Uniform(41);
    let turns = [(0.0, TAU), (TAU, 0.0), (0.0, TAU), (TAU, 0.0)];
    let sinusoids = [[24.0, 60.0, 0.4], [7.0, 25.0, 1.1]];
    let [train, heldout] = [(); 2].map(|()| stepped(&turns, [20.0, 24.0], &sinusoids, &mut random));
    let found = diagnose(&train.samples(), Some(&heldout.samples()), &DiagnoseOptions::default()).unwrap();
    assert_eq!(
        (found.verdict, found.effects.as_slice()),
        (Verdict::Effects, ["cogging"].as_slice()),
        "{}",
        found.summary
    );
    let cogging = &found.steps[0].parameters;
    assert!((cogging["cogging_per_turn"].value - 7.0).abs() < 0.01, "{cogging:?}");
    assert!((cogging["cogging_torque"].value - 25.0).abs() < 0.5, "{cogging:?}");
}

#[test]
fn a_measured_map_is_diagnosed_too() {
    let Some(columns) = measured("laas-cogging-map.csv") else { return };
    let samples = Samples {
        t_s: &columns[0],
        angle_rad: &columns[1],
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &columns[3],
    };
    let found = diagnose(&samples, None, &DiagnoseOptions::default()).unwrap();
    assert!(found.effects.contains(&"detent-harmonics"), "{}", found.summary);
    assert!(!found.complete && found.heldout_rms_after < found.heldout_rms_before, "{}", found.summary);
}

#[test]
fn the_sensors_zero_is_taken_out_of_a_map() {
    let mut random = Uniform(7);
    let mut capture = stepped(&[(0.0, 6.3), (6.3, 0.0)], [9.0, 11.0], &[[12.0, 20.0, 0.3]], &mut random);
    capture.torque_mnm.iter_mut().for_each(|torque| *torque += 5.0);
    let is_said = |fit: &Fit| fit.notes.iter().any(|note| note.contains("or the sensor's zero, looks the same"));
    assert!(is_said(&fit(&capture.samples(), &FitOptions::default()).unwrap()));
    let rig = run(&knobs::paper_knob(1).unwrap(), "linear-chirp", Drive::Position, None, 0.1, 1).calibration.unwrap();
    let known = Calibration { torque_zero_mnm: 5.0, ..rig };
    let fit = fit(&capture.samples(), &FitOptions { calibration: Some(known), ..FitOptions::default() }).unwrap();
    for (name, truth) in [("coulomb_negative", 9.0), ("coulomb_positive", 11.0)] {
        assert!((value(&fit, name) - truth).abs() < 0.3, "{name}");
    }
    assert!(!is_said(&fit), "{:?}", fit.notes);
}

#[test]
fn a_diagnosis_of_a_map_does_not_speak_of_speed() {
    let [one, other] = [(3, 6.3), (4, -6.3)]
        .map(|(seed, to)| stepped(&[(0.0, to), (to, 0.0)], [9.0, 11.0], &[[12.0, 20.0, 0.3]], &mut Uniform(seed)));
    let found = diagnose(&one.samples(), Some(&other.samples()), &DiagnoseOptions::default()).unwrap();
    assert!(!found.notes.iter().any(|note| note.contains("speed are correlated")), "{:?}", found.notes);
}
