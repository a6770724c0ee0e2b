//! Several captures made into one model: narrower intervals that still hold, wider ones where captures disagree.

use crate::common::{Capture, SLIDING, run, true_value};
use dynamics::{Drive, Effect, Model, Motion, effects, knobs};
use identification::{Fit, FitOptions, average, fit};

fn fitted(knob: &Model, sweep: &str, seed: u64) -> Fit {
    let capture = run(knob, sweep, Drive::Position, None, 8.0, seed);
    fit(&capture.samples(), &capture.options()).unwrap()
}

fn half_width(fit: &Fit, name: &str) -> f64 {
    let [low, high] = fit.parameters.get(name).unwrap().ci95.unwrap();
    0.5 * (high - low)
}

#[test]
fn the_mean_of_captures_has_narrower_intervals_that_still_hold_the_truth() {
    for number in [3, 4] {
        let knob = knobs::paper_knob(number).unwrap();
        let (mut told, mut held, mut narrower) = (0, 0, 0.0);
        for seed in 0..6 {
            let fits = [fitted(&knob, "linear-chirp", 2 * seed + 1), fitted(&knob, "stepped-amplitude", 2 * seed + 2)];
            let mean = average(&fits).unwrap();
            assert_eq!(mean.captures, 2);
            assert_eq!(mean.fit.samples, fits[0].samples + fits[1].samples);
            for name in SLIDING {
                let parameter = mean.fit.parameters.get(name).unwrap();
                let [low, high] = parameter.ci95.unwrap();
                told += 1;
                held += u32::from((low..=high).contains(&true_value(&knob, name).unwrap()));
                narrower += half_width(&mean.fit, name) / half_width(&fits[0], name).min(half_width(&fits[1], name));
            }
        }
        narrower /= f64::from(told);
        println!("knob {number}: {held} of {told} hold; intervals {narrower:.2} of the best capture's");
        assert!(held * 10 >= told * 9, "knob {number}: {held} of {told} intervals hold the truth");
        assert!(narrower < 1.3, "knob {number}: intervals grow to {narrower} of the best capture's");
    }
}

#[test]
fn captures_of_different_knobs_are_told_apart_and_widen_the_intervals() {
    let fits = [
        fitted(&knobs::paper_knob(3).unwrap(), "linear-chirp", 1),
        fitted(&knobs::paper_knob(4).unwrap(), "linear-chirp", 1),
    ];
    let mean = average(&fits).unwrap();
    let inertia = mean.fit.parameters.get("inertia").unwrap();
    let [low, high] = inertia.ci95.unwrap();
    assert!(low < 0.035 && 0.049 < high, "the interval {low} to {high} spans both knobs");
    assert!(mean.repeatability["inertia"].ratio > 5.0);
    assert!(mean.fit.notes.iter().any(|note| note.contains("are they of the same knob")), "{:?}", mean.fit.notes);
}

#[test]
fn the_mean_has_the_effects_of_every_capture() {
    let knob = knobs::paper_knob(4).unwrap();
    let with_detents = fitted(&knob, "linear-chirp", 1);
    let capture = run(&knob, "stepped-amplitude", Drive::Position, None, 8.0, 2);
    let offset = Effect::new(&effects::torque_offset::KIND, &[0.0]);
    let options = FitOptions { without_detents: true, further_effects: vec![offset], ..capture.options() };
    let with_offset = fit(&capture.samples(), &options).unwrap();
    for fits in [[with_detents.clone(), with_offset.clone()], [with_offset, with_detents]] {
        let model = average(&fits).unwrap().model("mean");
        let has = |name: &str| model.effects.iter().any(|effect| effect.kind().name == name);
        assert!(has("detent") && has("torque-offset"));
    }
}

#[test]
fn a_phase_near_the_cut_of_the_circle_does_not_average_to_zero() {
    // Phases of π − 0.01 and −π + 0.01 lie side by side.
    let mut knob = knobs::paper_knob(4).unwrap();
    let detent = knob.effects.iter_mut().find(|effect| effect.kind().name == "detent").unwrap();
    detent.values_mut()[0] = 11.0;
    detent.values_mut()[2] = std::f64::consts::PI;
    let fits: Vec<Fit> = (1..=4).map(|seed| fitted(&knob, "linear-chirp", seed)).collect();
    let mean = average(&fits).unwrap();
    let phase = mean.fit.parameters.get("detent_phase").unwrap().value.unwrap();
    assert!(phase.abs() > 3.1, "{phase}");
    assert!(mean.repeatability["detent_phase"].difference < 0.1);
}

#[test]
fn the_combined_json_keeps_every_key_of_a_single_fit() {
    let knob = knobs::paper_knob(3).unwrap();
    let fits = [fitted(&knob, "linear-chirp", 1), fitted(&knob, "linear-chirp", 2)];
    let single = serde_json::to_value(&fits[0]).unwrap();
    let json = serde_json::to_value(average(&fits).unwrap()).unwrap();
    for key in single.as_object().unwrap().keys().filter(|key| *key != "detent_harmonics") {
        assert!(json.get(key).is_some(), "{key} is missing");
    }
    assert_eq!(json["captures"], 2);
    assert_eq!(json["repeatability"]["inertia"]["values"].as_array().unwrap().len(), 2);
    assert!(json["parameters"]["inertia"]["ci95"][0].is_f64());
    let model = average(&fits).unwrap().model("knob 3");
    assert!(model.description.starts_with("mean of 2 captures"));
    let told = json["parameters"]["inertia"]["value"].as_f64().unwrap();
    assert!((model.inertia() - told).abs() < 1e-12, "the gripper is not in the model");
}

#[test]
fn one_capture_is_its_own_mean() {
    let only = fitted(&knobs::paper_knob(3).unwrap(), "linear-chirp", 1);
    let mean = average(std::slice::from_ref(&only)).unwrap();
    for name in SLIDING {
        let (own, same) = (only.parameters.get(name).unwrap(), mean.fit.parameters.get(name).unwrap());
        assert!((own.value.unwrap() - same.value.unwrap()).abs() < 1e-9, "{name}");
        assert!((half_width(&only, name) / half_width(&mean.fit, name) - 1.0).abs() < 0.05, "{name}");
    }
    assert!((mean.fit.residual_rms_mnm / only.residual_rms_mnm - 1.0).abs() < 1e-6);
    assert!(mean.repeatability.is_empty());
    assert!(average(&[]).is_none());
}

#[test]
fn the_residual_of_a_mean_is_that_of_its_model() {
    let knob = knobs::paper_knob(4).unwrap();
    let mut heavier = knob.clone();
    heavier.effects.iter_mut().find(|effect| effect.kind().name == "inertia").unwrap().values_mut()[0] *= 2.0;
    let (one, other) = (fitted(&knob, "linear-chirp", 1), fitted(&heavier, "linear-chirp", 2));
    let own = one.residual_rms_mnm.max(other.residual_rms_mnm);
    let mean = average(&[one.clone(), one.clone()]).unwrap();
    assert!((mean.fit.residual_rms_mnm / one.residual_rms_mnm - 1.0).abs() < 0.01);
    let mean = average(&[one, other]).unwrap();
    assert!(mean.fit.residual_rms_mnm > 2.0 * own, "{} against {own}", mean.fit.residual_rms_mnm);
}

#[test]
fn the_mean_of_maps_has_the_mean_of_their_further_sinusoids() {
    let map = |overtone_mnm: f64| {
        // A turn and a little more, forth and back.
        let angle_rad: Vec<f64> = (0..20_000).map(|row| 7.0 - (f64::from(row) * 7e-4 - 7.0).abs()).collect();
        let torque = |(row, angle_rad): (usize, &f64)| {
            let friction = if row < 10_000 { 1.0 } else { -1.0 };
            let noise = 0.05 * (12.9898 * (row * row % 7919) as f64).sin();
            10.0 * (8.0 * angle_rad).sin() + overtone_mnm * (24.0 * angle_rad).sin() + friction + noise
        };
        let torque_mnm: Vec<f64> = angle_rad.iter().enumerate().map(torque).collect();
        let t_s: Vec<f64> = (0..angle_rad.len()).map(|row| row as f64).collect();
        let capture = Capture { t_s, angle_rad, torque_mnm, ..Capture::default() };
        fit(&capture.samples(), &FitOptions { is_quasi_static: true, ..FitOptions::default() }).unwrap()
    };
    let fits = [map(1.0), map(3.0)];
    let [one, other] = [&fits[0], &fits[1]].map(|fit| fit.model("one"));
    let mean = average(&fits).unwrap().model("mean");
    let mut largest: f64 = 0.0;
    for step in 0..500 {
        let motion = Motion { angle_rad: 0.0123 * f64::from(step), velocity_rad_s: 0.1, ..Motion::default() };
        let [one, other, mean] = [&one, &other, &mean].map(|model| model.torque_mnm(&motion));
        largest = largest.max((one - other).abs());
        assert!((mean - 0.5 * (one + other)).abs() < 0.05, "{mean} of {one} and {other}");
    }
    assert!(largest > 1.5, "the maps differ by {largest} mNm at most");
}

#[test]
fn a_measured_curve_is_the_mean_of_all_captures() {
    let knob = knobs::paper_knob(3).unwrap();
    let mut steeper = knob.clone();
    steeper.effects.iter_mut().find(|effect| effect.kind().name == "detent").unwrap().values_mut()[0] *= 1.5;
    let measured = |knob: &Model, seed| {
        let capture = run(knob, "linear-chirp", Drive::Position, None, 8.0, seed);
        fit(&capture.samples(), &FitOptions { characteristic: true, ..capture.options() }).unwrap()
    };
    // The sinusoid's amplitude is √2 times its RMS.
    let amplitude = |fit: &Fit| {
        let points = &fit.characteristics[0].points;
        let known: Vec<f64> =
            points.iter().filter(|point| point.ci95.is_some()).map(|point| point.torque_mnm).collect();
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        (2.0 * known.iter().map(|torque| (torque - mean).powi(2)).sum::<f64>() / known.len() as f64).sqrt()
    };
    let fits = [measured(&knob, 1), measured(&knob, 2)];
    let alike = average(&fits).unwrap();
    let narrower = |at: usize| {
        let half = |fit: &Fit| fit.characteristics[0].points[at].ci95.map(|[low, high]| high - low);
        Some(half(&alike.fit)? / half(&fits[0])?)
    };
    let ratios: Vec<f64> = (0..alike.fit.characteristics[0].points.len()).filter_map(narrower).collect();
    let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
    println!(
        "mean of two curves: intervals {mean:.2} of one's, amplitudes {:.3} and {:.3} mNm",
        amplitude(&fits[0]),
        amplitude(&fits[1])
    );
    assert!(mean < 1.2);
    let other = measured(&steeper, 3);
    for fits in [[fits[0].clone(), other.clone()], [other.clone(), fits[0].clone()]] {
        let mean = average(&fits).unwrap();
        let (low, high, both) = (amplitude(&fits[0]), amplitude(&fits[1]), amplitude(&mean.fit));
        let middle = 0.5 * (low + high);
        assert!((both / middle - 1.0).abs() < 0.05, "{both} between {low} and {high}");
    }
}
