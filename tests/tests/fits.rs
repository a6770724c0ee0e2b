//! `fit` and `simulate` from the command line, on measured and simulated captures.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use serde_json::Value;
use tests::{Bench, printed};

fn fit_json(bench: &Bench, capture: &str) -> Value {
    let output = bench.run(&["fit", capture, "--json", "-"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_emps_axis_is_fitted_to_its_published_inertia_without_any_option() {
    let Some(folder) = measured_data::folder("measured") else { return };
    let bench = Bench::new().unwrap();
    let fit = fit_json(&bench, &folder.join("emps.csv").to_string_lossy());
    let value = |name: &str| fit["parameters"][name]["value"].as_f64();
    // Janot, Gautier and Brunot 2019: asymmetric model, 95.1540 kg, +20.1440 / -20.6277 N, relative error 3.112 %.
    let inertia = value("inertia").unwrap();
    assert!((inertia / 95.15 - 1.0).abs() < 0.005, "inertia {inertia}");
    assert!((value("coulomb_positive").unwrap() - 20.144).abs() < 1.0);
    assert!((value("coulomb_negative").unwrap() - 20.628).abs() < 1.0);
    let relative_error = fit["relative_error_percent"].as_f64().unwrap();
    assert!(relative_error <= 3.2, "relative error {relative_error} %");
    // A linear axis has no detents.
    assert_eq!(value("detent_amplitude"), None);
    assert!(fit["parameters"]["detent_amplitude"]["reason"].is_string());
}

#[test]
fn the_cogging_map_is_fitted_without_any_option() {
    let Some(folder) = measured_data::folder("measured") else { return };
    let bench = Bench::new().unwrap();
    let fit = fit_json(&bench, &folder.join("laas-cogging-map.csv").to_string_lossy());
    let counts: Vec<f64> =
        fit["detent_harmonics"].as_array().unwrap().iter().map(|one| one["per_turn"].as_f64().unwrap()).collect();
    for per_turn in [72.0, 18.0, 12.0, 24.0, 36.0] {
        assert!(counts.contains(&per_turn), "{per_turn} per turn is not among {counts:?}");
    }
    assert!(fit["relative_error_percent"].as_f64().unwrap() <= 18.4);
    let inertia = &fit["parameters"]["inertia"];
    assert!(inertia["value"].is_null() && inertia["reason"].as_str().unwrap().contains("sweep faster"));
}

#[test]
fn a_captured_knob_is_fitted_close_to_the_truth_and_every_parameter_without_a_value_has_its_reason() {
    let bench = Bench::new().unwrap();
    for (knob, inertia) in [("1", 0.091), ("2", 0.28), ("3", 0.035), ("4", 0.049)] {
        let folder = format!("knob-{knob}");
        let arguments = ["capture", "--knob", knob, "--duration-s", "6", "--no-viewer", "--out", folder.as_str()];
        let output = bench.run(&arguments).unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        let fit = fit_json(&bench, &bench.only_archive(&folder).unwrap().to_string_lossy());
        for key in ["residual_rms_mnm", "relative_error_percent", "mean_ci95_mnm", "samples"] {
            assert!(fit[key].is_number(), "knob {knob}: {key}");
        }
        let parameters = fit["parameters"].as_object().unwrap();
        for (name, parameter) in parameters {
            assert!(parameter["unit"].is_string());
            if parameter["value"].is_null() {
                assert!(parameter["reason"].as_str().is_some_and(|reason| !reason.is_empty()), "knob {knob}: {name}");
            } else {
                let (low, high) = (parameter["ci95"][0].as_f64().unwrap(), parameter["ci95"][1].as_f64().unwrap());
                assert!(low < high, "knob {knob}: {name} {low} {high}");
            }
        }
        let fitted = &parameters["inertia"];
        let half_width = 0.5 * (fitted["ci95"][1].as_f64().unwrap() - fitted["ci95"][0].as_f64().unwrap());
        let difference = (fitted["value"].as_f64().unwrap() - inertia).abs();
        // Five half widths: a single capture of unlucky noise passes, a bias does not.
        assert!(difference < 5.0 * half_width && difference < 0.01 * inertia, "knob {knob}: inertia {fitted}");
    }
}

#[test]
fn a_simulated_capture_fits_to_the_model_it_was_made_from() {
    let bench = Bench::new().unwrap();
    let output = bench.run(&["capture", "--knob", "4", "--duration-s", "6", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let archive = bench.only_archive("out").unwrap();
    let archive = archive.to_string_lossy();
    let text = "name = \"other\"\n[[effects]]\neffect = \"inertia\"\ninertia = 0.08\n\
                [[effects]]\neffect = \"friction\"\ncoulomb_negative = 4.0\ncoulomb_positive = 5.0\n\
                viscous_negative = 0.2\nviscous_positive = 0.3\n";
    std::fs::write(bench.path("other.toml"), text).unwrap();
    for output_name in ["simulated.mcap", "simulated.csv"] {
        let output = bench.run(&["simulate", "other.toml", "--like", &archive, "--out", output_name]).unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        let fit = fit_json(&bench, output_name);
        let value = |name: &str| fit["parameters"][name]["value"].as_f64().unwrap();
        // A table does not carry the gripper's inertia, which then counts as the knob's.
        let inertia = if output_name.ends_with(".csv") { 0.08 + 0.004 } else { 0.08 };
        assert!((value("inertia") - inertia).abs() < 0.01 * inertia, "{output_name}: {}", value("inertia"));
        assert!((value("coulomb_negative") - 4.0).abs() < 0.05, "{output_name}");
        assert!((value("viscous_positive") - 0.3).abs() < 0.01, "{output_name}");
    }

    let arguments = ["simulate", "out.toml", "--like", &archive, "--drive", "torque", "--out", "forward.mcap"];
    let model = bench.only_archive("out").unwrap().with_extension("toml");
    std::fs::copy(model, bench.path("out.toml")).unwrap();
    let output = bench.run(&arguments).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}
