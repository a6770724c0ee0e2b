//! What a capture cannot tell is said in a sentence, and what it can tell is still told.

use crate::common::{Uniform, ideal, knob, sweep};
use dynamics::{Effect, Motion, effects};
use identification::{FitError, FitOptions, Samples, fit};

const KNOB: [f64; 8] = [0.1, 3.0, 4.0, 0.5, 0.6, 2.0, 0.05, 0.3];

fn reason(fit: &identification::Fit, name: &str) -> String {
    let parameter = fit.parameters.get(name).unwrap();
    assert_eq!(parameter.value, None, "{name}");
    assert_eq!(parameter.ci95, None, "{name}");
    parameter.reason.clone().unwrap()
}

#[test]
fn a_knob_turned_one_way_only_tells_that_direction() {
    let motion = |time_s: f64| Motion {
        time_s,
        angle_rad: 4.0 * time_s + 0.5 * (5.0 * time_s).sin(),
        velocity_rad_s: 4.0 + 2.5 * (5.0 * time_s).cos(),
        acceleration_rad_s2: -12.5 * (5.0 * time_s).sin(),
    };
    let capture = ideal(&knob(&KNOB), motion, 0.5, &mut Uniform(3));
    let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
    for name in ["coulomb_negative", "viscous_negative"] {
        assert!(reason(&fit, name).contains("never slid in the negative direction"));
    }
    assert!((fit.parameters.get("coulomb_positive").unwrap().value.unwrap() - 4.0).abs() < 0.2);
    assert!((fit.parameters.get("detent_period").unwrap().value.unwrap() - 0.05).abs() < 1e-4);
    let model = fit.model("one way");
    assert_eq!(model.parameter("coulomb_negative"), model.parameter("coulomb_positive"));
    assert!(model.description.contains("coulomb_negative taken from coulomb_positive"));
}

#[test]
fn a_knob_turned_at_one_speed_does_not_tell_coulomb_from_viscous_friction() {
    let motion =
        |time_s: f64| Motion { time_s, angle_rad: 2.0 * time_s, velocity_rad_s: 2.0, acceleration_rad_s2: 0.0 };
    let capture = ideal(&knob(&KNOB), motion, 0.5, &mut Uniform(4));
    let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
    assert!(reason(&fit, "coulomb_positive").contains("viscous_positive"));
    assert!(reason(&fit, "viscous_positive").contains("coulomb_positive"));
    assert!(reason(&fit, "inertia").contains("accelerated too little"));
}

#[test]
fn a_knob_without_detents_has_none() {
    let mut values = KNOB;
    values[5] = 0.0;
    let capture = ideal(&knob(&values), sweep("linear-chirp"), 1.0, &mut Uniform(5));
    let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
    assert!(reason(&fit, "detent_amplitude").contains("no detents"));
    assert!(fit.model("smooth").effect("detent").is_none());
}

#[test]
fn what_serves_for_no_fit_at_all_is_an_error_that_says_why() {
    let capture = ideal(&knob(&KNOB), sweep("linear-chirp"), 1.0, &mut Uniform(6));
    let constant = vec![1.5; capture.t_s.len()];
    let still = Samples { angle_rad: &constant, velocity_rad_s: None, acceleration_rad_s2: None, ..capture.samples() };
    assert!(matches!(fit(&still, &FitOptions::default()), Err(FitError::NoMotion { .. })));
    let dead = Samples { torque_mnm: &constant, ..capture.samples() };
    assert!(matches!(fit(&dead, &FitOptions::default()), Err(FitError::ConstantTorque { .. })));
    let mut torque = capture.torque_mnm.clone();
    torque[7] = f64::NAN;
    let broken = Samples { torque_mnm: &torque, ..capture.samples() };
    let error = fit(&broken, &FitOptions::default()).unwrap_err();
    assert_eq!(error, FitError::NotFinite { column: "torque_mnm", index: 7 });
    let short = Samples {
        t_s: &capture.t_s[..50],
        angle_rad: &capture.angle_rad[..50],
        velocity_rad_s: None,
        acceleration_rad_s2: None,
        torque_mnm: &capture.torque_mnm[..50],
    };
    assert!(matches!(fit(&short, &FitOptions::default()), Err(FitError::TooFewSamples { samples: 50 })));
}

#[test]
fn the_json_has_the_agreed_keys() {
    let mut values = KNOB;
    values[5] = 0.0;
    let capture = ideal(&knob(&values), sweep("linear-chirp"), 1.0, &mut Uniform(7));
    let json = serde_json::to_value(fit(&capture.samples(), &FitOptions::default()).unwrap()).unwrap();
    for key in ["residual_rms_mnm", "relative_error_percent", "mean_ci95_mnm", "samples"] {
        assert!(json[key].is_number(), "{key}");
    }
    let inertia = &json["parameters"]["inertia"];
    assert!(inertia["value"].is_number() && inertia["unit"] == "mNm s²/rad" && inertia["ci95"][1].is_number());
    let amplitude = &json["parameters"]["detent_amplitude"];
    assert!(amplitude["value"].is_null() && amplitude["ci95"].is_null() && amplitude["reason"].is_string());
}

#[test]
fn lost_samples_leave_the_parameters_where_they_were() {
    let capture = ideal(&knob(&KNOB), sweep("linear-chirp"), 0.2, &mut Uniform(8));
    let keep = |index: &usize| !(12_000..12_400).contains(index) && !(20_000..20_003).contains(index);
    let kept = |column: &[f64]| {
        column.iter().enumerate().filter(|(index, _)| keep(index)).map(|(_, value)| *value).collect::<Vec<f64>>()
    };
    let (t_s, angle, torque) = (kept(&capture.t_s), kept(&capture.angle_rad), kept(&capture.torque_mnm));
    let samples =
        Samples { t_s: &t_s, angle_rad: &angle, velocity_rad_s: None, acceleration_rad_s2: None, torque_mnm: &torque };
    let fit = fit(&samples, &FitOptions::default()).unwrap();
    assert_eq!(fit.preparation.lost_samples, 403);
    for (name, truth) in [("inertia", 0.1), ("coulomb_positive", 4.0), ("detent_amplitude", 2.0)] {
        let value = fit.parameters.get(name).unwrap().value.unwrap();
        assert!((value / truth - 1.0).abs() < 0.01, "{name} is {value}");
    }
}

#[test]
fn friction_that_a_drag_takes_below_zero_has_no_interval() {
    let mut knob = knob(&[0.1, 0.5, 0.5, 0.0, 0.0, 2.0, 0.05, 0.3]);
    knob.effects.push(Effect::new(&effects::quadratic_drag::KIND, &[0.2]));
    for seed in 1..=5 {
        let capture = ideal(&knob, sweep("paper"), 0.5, &mut Uniform(seed));
        let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
        for name in ["coulomb_negative", "coulomb_positive"] {
            assert!(reason(&fit, name).contains("something that the model lacks drives the knob"));
        }
    }
}

#[test]
fn all_samples_that_a_long_gap_lost_are_counted() {
    let mut capture = ideal(&knob(&KNOB), sweep("linear-chirp"), 0.5, &mut Uniform(5));
    let is_kept = |index: usize| !(12_000..22_000).contains(&index);
    for column in [&mut capture.t_s, &mut capture.angle_rad, &mut capture.torque_mnm]
        .into_iter()
        .chain(&mut capture.velocity_rad_s)
        .chain(&mut capture.acceleration_rad_s2)
    {
        let mut index = 0..;
        column.retain(|_| index.next().is_some_and(is_kept));
    }
    let fit = fit(&capture.samples(), &FitOptions::default()).unwrap();
    assert_eq!(fit.preparation.lost_samples, 10_000);
}
