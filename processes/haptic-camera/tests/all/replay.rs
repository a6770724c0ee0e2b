//! `replay` without a clock: the proof of a rendering, and what is refused.

use std::path::Path;
use std::process::Output;

use crate::program::{call, errors, json};
use serde_json::Value;

fn replay(folder: &Path, arguments: &str) -> Output {
    call(folder, &format!("replay --offline {arguments}"))
}

/// A model of an inertia and of what is given besides.
fn model(folder: &Path, inertia: &str, besides: &str) {
    let text = format!("name = \"tried\"\n[[effects]]\neffect = \"inertia\"\ninertia = {inertia}\n{besides}");
    std::fs::write(folder.join("model.toml"), text).unwrap();
}

fn refused(folder: &Path, arguments: &str) -> String {
    let said = crate::program::refused(folder, &format!("replay --offline {arguments}"));
    assert!(!folder.join("captures").read_dir().is_ok_and(|mut files| files.next().is_some()), "nothing is captured");
    said
}

#[test]
fn a_rendered_knob_captured_from_its_replay_is_its_model() {
    let folder = tempfile::tempdir().unwrap();
    let output = replay(folder.path(), "4 --verify --json result.json --report page.html");
    let result = json(&folder.path().join("result.json"));
    let parameters = result["parameters"].as_array().unwrap();
    assert_eq!(parameters.len(), 10, "all of the model's but the stick velocity, which shows in no torque");
    for parameter in parameters {
        let [intended, rendered] = ["intended", "rendered"].map(|key| parameter[key].as_f64().unwrap());
        let [low, high] = [0, 1].map(|end| parameter["ci95"][end].as_f64().unwrap());
        let name = parameter["name"].as_str().unwrap();
        let limit = if name.starts_with("static_") { 0.05 } else { 0.02 };
        let held = (low..=high).contains(&intended);
        assert!(held || (rendered - intended).abs() < limit * intended.abs(), "{parameter}");
    }
    let [error, torque] = ["torque_error_rms_mnm", "torque_rms_mnm"].map(|key| result[key].as_f64().unwrap());
    assert!(error < 0.05 * torque, "{error} of {torque} mNm");
    assert!(result["held_still"]["encoder_steps"].as_f64().unwrap() < 1.0, "{result}");
    // The coupling gives way a little, which is a shaft wherever a diagnosis sees it.
    let added = result["added"]["effects"].as_array().unwrap();
    assert!(added.iter().all(|effect| effect == "shaft-compliance"), "{}", result["added"]);
    assert_ne!(result["added"]["verdict"], "outside-library");
    let [before, floor] = ["heldout_rms_before", "noise_floor_rms"].map(|key| result["added"][key].as_f64().unwrap());
    assert!(before < 1.12 * floor, "{before} of {floor} mNm");
    assert_eq!(output.status.code(), Some(0));
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    let mut shown = result.clone();
    // What the page says of the capture it says in words and dates.
    shown.as_object_mut().unwrap().remove("capture");
    let missing = not_shown(&page, &shown);
    assert!(missing.is_empty(), "not on the page: {missing:?}");
    let missing = crate::pages::not_in_json(&page, &result);
    assert!(missing.is_empty(), "on the page and not in the JSON: {missing:#?}");
    assert!(crate::pages::compared(&page) >= 50, "only {} numbers were compared", crate::pages::compared(&page));
}

/// Numbers of the JSON that are not on the page, with the way to them.
fn not_shown(page: &str, result: &Value) -> Vec<String> {
    let plain = page.split_once("</style>").unwrap().1.replace('−', "-");
    let shown: Vec<f64> = plain
        .split(|letter: char| !(letter.is_ascii_digit() || "-.".contains(letter)))
        .filter_map(|word| word.trim_end_matches('.').parse().ok())
        .collect();
    let mut missing = Vec::new();
    let mut left = vec![(String::new(), result)];
    while let Some((way, value)) = left.pop() {
        match value {
            Value::Array(items) => {
                left.extend(items.iter().enumerate().map(|(index, item)| (format!("{way}[{index}]"), item)));
            }
            Value::Object(fields) => left.extend(fields.iter().map(|(name, item)| (format!("{way}.{name}"), item))),
            Value::Number(number) => {
                let number = number.as_f64().unwrap();
                // Three significant digits, or those that an interval's width supports; percents with two decimals.
                let share = if way.contains("ci95") { 0.01 } else { 0.005 };
                let rounding = share * number.abs() + if way.ends_with("percent") { 0.005_001 } else { 1e-9 };
                if !shown.iter().any(|on_page| (on_page - number).abs() <= rounding) {
                    missing.push(format!("{way} = {number}"));
                }
            }
            _ => {}
        }
    }
    missing
}

#[test]
fn what_the_rig_cannot_render_is_refused_with_the_nearest_that_would_do() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let tried = |inertia: &str, besides: &str| {
        model(folder, inertia, besides);
        refused(folder, "model.toml")
    };
    let detent = |amplitude: f64, period: f64| {
        format!(
            "[[effects]]\neffect = \"detent\"\ndetent_amplitude = {amplitude}\ndetent_period = {period}\ndetent_phase = 0.0\n"
        )
    };
    assert!(tried("0.01", "").contains("inertia = 0.0199"));
    assert!(tried("4.0", "").contains("the inertia is 4.0000 mNm·s²/rad, but the rig renders at most 0.3247"));
    assert!(tried("nan", "").to_lowercase().contains("nan"));
    let stick = "[[effects]]\neffect = \"karnopp-stick\"\nstatic_negative = 400.0\nstatic_positive = 400.0\n\
                 stick_velocity = 0.01\n";
    assert!(tried("0.05", stick).contains("the largest torque is 400.0000 mNm, but the rig renders at most 324.7200"));
    assert!(tried("0.05", &detent(40.0, 0.001)).contains("the steepest rise of torque over angle is 40000.0"));
    let gap = "[[effects]]\neffect = \"backlash\"\nbacklash_half_gap = 0.01\nbacklash_inner_share = 0.5\n\
               backlash_stiffness = 1e5\nbacklash_damping = 2.0\n";
    assert!(tried("0.05", gap).contains("the stiffness of contact or shaft is 100000.0000 mNm/rad"));
    assert!(tried("0.02", gap).contains("a cap of 0.01 mNm·s²/rad"));
    let bristles =
        "[[effects]]\neffect = \"presliding-hysteresis\"\nbristle_deflection = 0.01\nbristle_damping = 0.0\n";
    assert!(tried("0.05", bristles).contains("'presliding-hysteresis' cannot be rendered"));
    assert!(refused(folder, "7").contains("no shipped knob 7"));
    assert!(refused(folder, "3 --hand backwards").contains("no sweep 'backwards'"));
}

#[test]
fn a_rate_at_which_the_rig_must_hold_the_model_softly_is_reported_with_a_firmer_one() {
    let folder = tempfile::tempdir().unwrap();
    let output = replay(folder.path(), "3 --rate-hz 3000 --duration-s 0.5");
    let said = errors(&output);
    assert!(output.status.success() && said.contains("--rate-hz 10000 couples it more firmly"), "{said}");
}

#[test]
fn the_nearest_that_the_rig_renders_is_rendered_and_reported_on_request() {
    let folder = tempfile::tempdir().unwrap();
    refused(folder.path(), "5");
    let output = replay(folder.path(), "5 --nearest --duration-s 1");
    let said = errors(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    assert!(said.contains("inertia = 0.02085 mNm s²/rad instead of 0.0019"), "{said}");
    let archive = folder.path().join("captures").read_dir().unwrap().next().unwrap().unwrap().path();
    let run = archive::Capture::load(&archive).unwrap().description.unwrap();
    assert!(run.notes.iter().any(|(_, note)| note.contains("instead of 0.0019")), "{:?}", run.notes);
    let rendered = dynamics::Model::from_toml(&run.rendered_model_toml.unwrap(), "the archive").unwrap();
    assert!((rendered.inertia() - 0.02085).abs() < 1e-6, "the model as rendered is the clipped one");
    assert!(rendered.coupling().is_some());
}

#[test]
fn a_rig_whose_own_friction_is_unknown_renders_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let calibration = "gripper_inertia = 0.004\nmotor_inertia = 0.0159\ntorque_sensor_stiffness_mnm_rad = 5e5\n\
        torque_zero_mnm = 0.6\ntorque_delay_s = 0.0\nacceleration_zero_rad_s2 = 0.0\nacceleration_delay_s = 0.0\n\
        gravity_amplitude_rad_s2 = 490.5\ngravity_phase_rad = 0.7\nangle_step_rad = 9.8e-6\ntorque_step_mnm = 0.18\n\
        acceleration_step_rad_s2 = 2.8\n";
    std::fs::write(folder.path().join("rig.toml"), calibration).unwrap();
    assert!(refused(folder.path(), "3 --calibration rig.toml").contains("calibrate friction"));
}
