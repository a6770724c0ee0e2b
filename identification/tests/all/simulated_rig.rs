//! Knobs of the paper on the simulated rig: stick, noise, delays, compliance, gripper.

use crate::common::{Capture, run, true_value};
use dynamics::{Axis, Drive, knobs};
use identification::diagnosis::{DiagnoseOptions, diagnose};
use identification::fit;
use identification::live::{LiveFit, LiveSample, Verdict};

/// Ten seconds of a paper's knob that follows the linear chirp.
fn rig(number: u32, seed: u64) -> Capture {
    run(&knobs::paper_knob(number).unwrap(), "linear-chirp", Drive::Position, None, 10.0, seed)
}

fn truth(number: u32, name: &str) -> Option<f64> {
    true_value(&knobs::paper_knob(number).unwrap(), name)
}

fn stream(live: &mut LiveFit, capture: &Capture, keep: impl Fn(usize) -> bool) {
    for index in (0..capture.t_s.len()).filter(|index| keep(*index)) {
        live.push(&LiveSample {
            time_s: capture.t_s[index],
            angle_rad: capture.angle_rad[index],
            torque_mnm: capture.torque_mnm[index],
        });
        if index % 500 == 0 {
            let _ = live.estimate();
        }
    }
}

#[test]
fn intervals_hold_the_truth_of_knobs_1_to_4() {
    let (mut told, mut held) = (0, 0);
    for number in 1..=4 {
        for seed in 1..=5 {
            let capture = rig(number, seed);
            let options = capture.options();
            let fit = fit(&capture.samples(), &options).unwrap();
            assert_eq!(fit.parameters.get("detent_period").unwrap().value.is_some(), number >= 3);
            for parameter in fit.parameters.0.iter().filter(|parameter| !parameter.name.starts_with("static")) {
                let Some([low, high]) = parameter.ci95 else { continue };
                let truth = truth(number, parameter.name).unwrap();
                told += 1;
                held += u32::from(low <= truth && truth <= high);
            }
        }
    }
    assert_eq!(told, 2 * 5 * (5 + 8));
    assert!(held >= told * 9 / 10, "{held} of {told} intervals hold the truth");
}

#[test]
fn the_live_fit_comes_to_the_values_of_the_whole_capture() {
    for number in [1, 3, 4] {
        let capture = rig(number, 11);
        let mut live = LiveFit::new(10_000.0, Axis::Rotary, capture.calibration.as_ref());
        stream(&mut live, &capture, |_| true);
        let estimate = live.estimate();
        let options = capture.options();
        let whole = fit(&capture.samples(), &options).unwrap();
        for parameter in &estimate.parameters {
            let [value, expected] = [parameter.value, whole.parameters.get(parameter.name).unwrap().value];
            assert_eq!(value.is_some(), expected.is_some(), "{}", parameter.name);
            let Some((value, expected)) = value.zip(expected) else {
                assert_eq!(parameter.verdict, Verdict::Absent);
                continue;
            };
            assert_eq!(parameter.verdict, Verdict::Estimated, "{}", parameter.name);
            let [low, high] = parameter.ci95.unwrap();
            assert!((value - expected).abs() < high - low, "{}: {value} against {expected}", parameter.name);
        }
    }
}

#[test]
fn samples_that_are_missing_here_and_there_do_not_keep_the_live_fit_from_its_values() {
    let capture = rig(4, 11);
    let mut live = LiveFit::new(10_000.0, Axis::Rotary, capture.calibration.as_ref());
    // Two of seven.
    stream(&mut live, &capture, |index| index * index % 7 != 2);
    let estimate = live.estimate();
    let whole = fit(&capture.samples(), &capture.options()).unwrap();
    for parameter in &estimate.parameters {
        let expected = whole.parameters.get(parameter.name).unwrap().value.unwrap();
        assert_eq!(parameter.verdict, Verdict::Estimated, "{}", parameter.name);
        let ([low, high], value) = (parameter.ci95.unwrap(), parameter.value.unwrap());
        assert!((value - expected).abs() < high - low, "{}: {value} against {expected}", parameter.name);
    }
}

#[test]
fn a_gap_in_the_stream_does_not_corrupt_the_live_fit() {
    let capture = rig(4, 12);
    let mut live = LiveFit::new(10_000.0, Axis::Rotary, capture.calibration.as_ref());
    stream(&mut live, &capture, |index| !(40_000..43_000).contains(&index) && index % 7001 != 0);
    let estimate = live.estimate();
    for (name, tolerance) in [("inertia", 0.002), ("viscous_positive", 0.01), ("detent_amplitude", 0.002)] {
        let value = estimate.parameter(name).unwrap().value.unwrap();
        let truth = truth(4, name).unwrap();
        assert!((value / truth - 1.0).abs() < tolerance, "{name} is {value}");
    }
}

#[test]
fn a_stream_that_has_not_moved_the_knob_tells_nothing_yet() {
    let mut live = LiveFit::new(10_000.0, Axis::Rotary, None);
    for tick in 0..20_000 {
        live.push(&LiveSample { time_s: f64::from(tick) * 1e-4, angle_rad: 0.1, torque_mnm: f64::from(tick % 3) });
    }
    live.push(&LiveSample { time_s: 1.0, angle_rad: 0.1, torque_mnm: 0.0 });
    live.push(&LiveSample { time_s: 3.0, angle_rad: f64::NAN, torque_mnm: 0.0 });
    let estimate = live.estimate();
    assert_eq!(estimate.parameters.len(), 8);
    assert!(estimate.parameters.iter().all(|p| p.value.is_none() && p.verdict == Verdict::NotYet));
    assert_eq!((estimate.samples, estimate.ignored_samples), (20_000, 2));
}

#[test]
fn a_diagnosis_has_the_knobs_inertia_without_the_grippers() {
    let [train, heldout] = [1, 2].map(|seed| rig(3, seed));
    let options = DiagnoseOptions { calibration: train.calibration.clone(), ..DiagnoseOptions::default() };
    let found = diagnose(&train.samples(), Some(&heldout.samples()), &options).unwrap();
    let inertia = truth(3, "inertia").unwrap();
    assert!((found.model.inertia() / inertia - 1.0).abs() < 0.01, "{} of {inertia}", found.model.inertia());
}
