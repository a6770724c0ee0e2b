//! `capture --diagnose` on the simulated rig offline: the rig runs experiments until one name is left.

use std::path::Path;
use std::process::Output;

use crate::program::{call, command, files, json, words};
use serde_json::Value;

/// Inertia, friction and detents without Karnopp's stick.
const BASE: &str = r#"
name = "test"
description = ""
[[effects]]
effect = "inertia"
inertia = 0.05
[[effects]]
effect = "friction"
coulomb_negative = 5.0
coulomb_positive = 5.5
viscous_negative = 0.4
viscous_positive = 0.5
[[effects]]
effect = "detent"
detent_amplitude = 4.0
detent_period = 0.1
detent_phase = 0.3
"#;

/// Over a third of a turn a spring in all but name.
const IMBALANCE: &str = r#"
[[effects]]
effect = "mass-imbalance"
imbalance_torque = 0.15
imbalance_phase = 0.2
"#;

fn capture(folder: &Path, effects: &str, options: &[&str]) -> Output {
    std::fs::write(folder.join("knob.toml"), format!("{BASE}{effects}")).unwrap();
    let common = "capture --diagnose --offline --knob knob.toml --rate-hz 4000 --duration-s 8 --amplitude 0.5 \
                  --out out --json diagnosis.json";
    command(folder, common).args(options).output().unwrap()
}

#[test]
fn rivals_that_the_first_captures_cannot_distinguish_are_distinguished_by_one_more() {
    let folder = tempfile::tempdir().unwrap();
    let output = capture(folder.path(), IMBALANCE, &["--reach", "1.5", "--budget", "4"]);
    let said = words(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("a tie") && said.contains("capture 3: to discriminate between"), "{said}");
    let found = json(&folder.path().join("diagnosis.json"));
    assert_eq!(found["verdict"], "effects");
    assert_eq!(found["effects"], serde_json::json!(["mass-imbalance"]), "{said}");
    assert_eq!(found["steps"][0]["ties"], serde_json::json!([]));
    let value = found["steps"][0]["parameters"]["imbalance_torque"]["value"].as_f64().unwrap();
    assert!((value - 0.15).abs() < 0.03, "{value} mNm");
    let archives = files(&folder.path().join("out"), "mcap");
    assert!(archives.len() > 2, "every capture is a file of its own: {archives:?}");
    for archive in archives {
        assert_eq!(archive::Capture::load(&archive).unwrap().len(), 32_000, "{}", archive.display());
    }
    assert_eq!(
        (files(&folder.path().join("out"), "html").len(), files(&folder.path().join("out"), "toml").len()),
        (1, 1)
    );
    let errors = found["forward_from_command"]["angle_rms_rad"].as_array().unwrap();
    assert_eq!(errors.len(), 2, "before the effect and after it");
    assert!(errors[1].as_f64() < errors[0].as_f64(), "{errors:?}");
}

#[test]
fn rivals_stay_tied_where_the_budget_is_spent_or_nothing_within_reach_tells_them_apart() {
    for (options, expected) in [
        (["--reach", "1.5", "--budget", "16s"], "the budget is spent"),
        (["--reach", "0.5", "--budget", "5"], "--reach"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let output = capture(folder.path(), IMBALANCE, &options);
        let said = words(&output);
        assert_eq!(output.status.code(), Some(0), "{said}");
        assert!(said.contains(expected), "{said}");
        assert_eq!(files(&folder.path().join("out"), "mcap").len(), 2);
        let found = json(&folder.path().join("diagnosis.json"));
        assert_ne!(found["steps"][0]["ties"], serde_json::json!([]), "{said}");
    }
}

#[test]
fn a_knob_that_lacks_nothing_is_settled_after_two_captures() {
    let folder = tempfile::tempdir().unwrap();
    let output = capture(folder.path(), "", &[]);
    let said = words(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert_eq!(json(&folder.path().join("diagnosis.json"))["verdict"], "none", "{said}");
    assert!(said.contains("settled after 2 captures"), "{said}");
    assert_eq!(files(&folder.path().join("out"), "mcap").len(), 2);
}

#[test]
fn backlash_and_harmonics_of_the_papers_knob_5_are_named_where_it_does_not_stick() {
    let mut knob = dynamics::knobs::paper_knob(5).unwrap();
    knob.effects.retain(|effect| !matches!(effect.kind().part, dynamics::Part::Stick(_)));
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("knob.toml"), knob.to_toml()).unwrap();
    let options = "capture --diagnose --offline --knob knob.toml --rate-hz 4000 --duration-s 4 --out out \
                   --json diagnosis.json";
    let output = call(folder.path(), options);
    let said = words(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let found = json(&folder.path().join("diagnosis.json"));
    let mut names: Vec<&str> = found["effects"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    names.sort_unstable();
    assert_eq!(names, ["backlash", "detent-harmonics"], "{said}");
    assert!(found["steps"].as_array().unwrap().iter().all(|step| step["ties"] == serde_json::json!([])), "{said}");
    // Of the knob's file.
    let value = |name: &str| {
        let steps = found["steps"].as_array().unwrap().iter();
        steps.filter_map(|step| step["parameters"][name]["value"].as_f64()).next().unwrap()
    };
    for (name, truth) in [("backlash_half_gap", 0.013), ("harmonic_2_cosine", 23.64), ("harmonic_3_sine", 19.3)] {
        assert!((value(name) / truth - 1.0).abs() < 0.05, "{name} is {}, in truth {truth}", value(name));
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (options, status, expected) in [
        (vec!["--budget", "much"], 2, "seconds of turning"),
        (vec!["--budget", "5m"], 2, "seconds of turning"),
        (vec!["--budget", "NaNs"], 2, "seconds of turning"),
        (vec!["--budget", "1.5"], 2, "seconds of turning"),
        (vec!["--torque"], 2, "cannot be used with"),
        (vec!["--reach=-1"], 2, "--reach"),
    ] {
        let output = capture(folder.path(), "", &options);
        assert_eq!(output.status.code(), Some(status), "{options:?}");
        assert!(words(&output).contains(expected), "{options:?}: {}", words(&output));
    }
}
