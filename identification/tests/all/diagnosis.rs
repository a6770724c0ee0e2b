//! Effects hidden by others are named from captures alone; what cannot be told is refused with its sentence.

use crate::common::{Capture, Uniform, table};
use crate::hidden::hidden;
use identification::diagnosis::{DiagnoseOptions, Diagnosis, DiagnosisError, Verdict, diagnose};

fn diagnosed(train: &Capture, heldout: Option<&Capture>) -> Result<Diagnosis, DiagnosisError> {
    let heldout = heldout.map(Capture::samples);
    diagnose(&train.samples(), heldout.as_ref(), &DiagnoseOptions::default())
}

/// The verdict as the answers give it: names, or `none`, or `outside-library`.
fn verdict(found: &Diagnosis) -> Vec<String> {
    let mut names: Vec<String> = match found.verdict {
        Verdict::None => vec!["none".to_owned()],
        Verdict::OutsideLibrary => vec!["outside-library".to_owned()],
        Verdict::Effects => found.effects.iter().map(|name| (*name).to_owned()).collect(),
    };
    names.sort();
    names
}

#[test]
fn what_an_independent_simulator_hid_is_named_and_the_gap_closed() {
    let Some(folder) = measured_data::folder("hidden-effects-dev") else { return };
    let answers: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("answers.json")).unwrap()).unwrap();
    for (id, answer) in answers.as_object().unwrap() {
        let mut right: Vec<String> =
            answer["effects"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect();
        if right.is_empty() {
            right.push(answer["verdict"].as_str().unwrap().to_owned());
        }
        right.sort();
        let [train, heldout] = ["train.csv", "heldout.csv"].map(|file| table(&folder.join(id).join(file)));
        let found = diagnosed(&train, Some(&heldout)).unwrap();
        assert_eq!(verdict(&found), right, "{id}: {}", found.summary);
        if found.verdict == Verdict::Effects {
            assert!(found.heldout_rms_after < 0.3 * found.heldout_rms_before, "{id}: {}", found.summary);
            let step = &found.steps[0];
            assert!(step.placebo_rms > 0.9 * step.heldout_rms_before, "{id}: a placebo closes the gap");
        }
    }
}

#[test]
fn effects_hidden_by_the_plant_are_named_at_three_times_the_noise() {
    let mut wrong = Vec::new();
    for (seed, effect) in
        [(1, "stribeck"), (2, "mass-imbalance"), (3, "quadratic-drag"), (4, "friction-drift"), (5, "cogging")]
    {
        let ([train, heldout], _) = hidden(1000 + seed, effect, 3.0);
        let found = diagnosed(&train, Some(&heldout)).unwrap();
        if verdict(&found) != [effect] {
            wrong.push(format!("{effect}: {}", found.summary));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    for seed in 0..4 {
        let ([train, heldout], _) = hidden(2000 + seed, "none", 3.0);
        let found = diagnosed(&train, Some(&heldout)).unwrap();
        assert_eq!(found.verdict, Verdict::None, "seed {seed}: {}", found.summary);
        assert!(found.effects.is_empty() && found.steps.is_empty());
    }
}

#[test]
fn stretches_of_one_capture_are_held_out_where_there_is_no_other_and_that_is_said() {
    let ([train, _], _) = hidden(3000, "mass-imbalance", 10.0);
    let found = diagnosed(&train, None).unwrap();
    assert_eq!(verdict(&found), ["mass-imbalance"]);
    assert!(found.heldout_is_own && found.notes.iter().any(|note| note.contains("weaker")), "{:?}", found.notes);
}

#[test]
fn captures_that_permit_no_verdict_are_refused_with_the_reason() {
    let ([train, heldout], _) = hidden(4000, "none", 3.0);
    let refused = |heldout: &Capture| diagnosed(&train, Some(heldout)).unwrap_err();
    assert!(matches!(refused(&train), DiagnosisError::SameCapture));

    let every_other = |column: &[f64]| column.iter().step_by(2).copied().collect::<Vec<f64>>();
    let slower = Capture {
        t_s: every_other(&heldout.t_s),
        angle_rad: every_other(&heldout.angle_rad),
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: every_other(&heldout.torque_mnm),
        calibration: None,
    };
    assert_eq!(diagnosed(&train, Some(&slower)).unwrap().verdict, Verdict::None, "two rates are no obstacle");

    let mut newton_metres = heldout.clone();
    newton_metres.torque_mnm.iter_mut().for_each(|torque| *torque *= 1e-3);
    let error = refused(&newton_metres);
    assert!(matches!(error, DiagnosisError::DifferentUnits { .. } | DiagnosisError::TooQuiet { .. }), "{error}");

    let mut short = heldout.clone();
    for column in [&mut short.t_s, &mut short.angle_rad, &mut short.torque_mnm] {
        column.truncate(10);
    }
    short.velocity_rad_s = None;
    short.acceleration_rad_s2 = None;
    let error = refused(&short).to_string();
    assert!(error.starts_with("the held-out capture: "), "{error}");
}

/// A knob of 0.2 mNm s²/rad with friction under two tones, its torque read `delay_s` late, at 1 kHz through a fine encoder; `drag`
/// is its viscous friction over the angle.
fn turned(delay_s: f64, drag: impl Fn(f64) -> f64, tones_hz: [f64; 2], seed: u64) -> Capture {
    let mut random = Uniform(seed);
    let tones = [(std::f64::consts::TAU * tones_hz[0], 1.0), (std::f64::consts::TAU * tones_hz[1], 0.05)];
    let sum = |term: &dyn Fn(f64, f64) -> f64| tones.iter().map(|(w, size)| term(*w, *size)).sum::<f64>();
    let step = std::f64::consts::TAU / 65_536.0;
    let mut capture = Capture { t_s: (0..12_000).map(|index| f64::from(index) * 1e-3).collect(), ..Capture::default() };
    for now in capture.t_s.clone() {
        let then = now - delay_s;
        let velocity = sum(&|w, size| size * w * (w * then).cos());
        let acceleration = sum(&|w, size| -size * w * w * (w * then).sin());
        let angle = |time: f64| sum(&|w, size| size * (w * time).sin());
        capture.angle_rad.push((angle(now) / step).round() * step);
        let torque = 0.2 * acceleration + 2.0 * velocity.signum() + drag(angle(then)) * velocity;
        capture.torque_mnm.push(torque + 0.05 * random.normal());
    }
    capture
}

#[test]
fn a_delay_is_named_with_its_whole_length_also_between_samples() {
    for (delay_s, seed) in [(1e-3, 3), (0.7e-3, 5), (1.3e-3, 7), (0.3e-3, 9), (-0.4e-3, 13)] {
        let [train, heldout] =
            [(seed, [1.0, 7.3]), (seed + 1, [1.4, 5.1])].map(|(seed, tones)| turned(delay_s, |_| 0.05, tones, seed));
        let found = diagnosed(&train, Some(&heldout)).unwrap();
        assert_eq!(found.effects, ["sensor-delay"], "{}", found.summary);
        let delay = found.steps[0].parameters["sensor_delay"];
        assert!((delay.value - delay_s).abs() < 1e-5, "{delay:?} for {delay_s} s");
    }
}

#[test]
fn channels_that_are_read_one_after_the_other_have_no_delay() {
    let [train, heldout] =
        [(3, [1.0, 7.3]), (4, [1.4, 5.1])].map(|(seed, tones)| turned(0.1e-3, |_| 0.05, tones, seed));
    let found = diagnosed(&train, Some(&heldout)).unwrap();
    assert_eq!(found.verdict, Verdict::None, "{}", found.summary);
}

/// A first-order filter passes the torque of an inertia as a shaft does whose damping exceeds the critical one.
#[test]
fn a_filter_of_the_torque_is_a_delay_and_no_shaft() {
    let [train, heldout] = [(21, [1.0, 7.3]), (22, [1.4, 5.1])].map(|(seed, tones)| {
        let mut capture = turned(0.0, |_| 0.05, tones, seed);
        let mut passed = capture.torque_mnm[0];
        for torque_mnm in &mut capture.torque_mnm {
            passed += (*torque_mnm - passed) / 5.0;
            *torque_mnm = passed;
        }
        capture
    });
    let found = diagnosed(&train, Some(&heldout)).unwrap();
    assert!(found.effects.contains(&"sensor-delay"), "{}", found.summary);
    assert!(!found.effects.contains(&"shaft-compliance"), "{}", found.summary);
}

#[test]
fn a_damper_beyond_an_angle_is_no_end_stop() {
    let drag = |angle: f64| if angle > 0.8 { 0.3 } else { 0.05 };
    let [train, heldout] = [(11, [1.0, 7.3]), (12, [1.4, 5.1])].map(|(seed, tones)| turned(0.0, drag, tones, seed));
    let found = diagnosed(&train, Some(&heldout)).unwrap();
    assert!(found.verdict != Verdict::None && !found.effects.contains(&"end-stop"), "{}", found.summary);
}
