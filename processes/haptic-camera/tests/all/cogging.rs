//! A rig whose motor cogs: calibrated, and rendering as if it did not.

use std::path::Path;

use crate::program::{call, done, errors, json, only};
use serde_json::Value;

/// A slotted motor of 12 slots and 16 poles: 1.4 % of a rated torque of 100 mNm, and what its making left unequal.
const COGGING: &str = "--offline --motor-cogging=48:1.4:0.4 --motor-cogging=12:0.6:-1.1 --motor-cogging=16:0.3:2.0";

/// The fit of the only archive in a folder.
fn fitted(folder: &Path) -> Value {
    let archive = only(folder, "mcap");
    serde_json::from_str(&done(folder, &format!("fit --json - {}", archive.display()))).unwrap()
}

/// Knob 3, felt through a sweep whose speed its friction does not drive; its fit.
fn felt(folder: &Path, out: &str, further: &str) -> Value {
    let hand = "--hand linear-chirp --amplitude 0.45 --grip 6 --duration-s 10";
    done(folder, &format!("replay 3 {hand} --out {out} {further} {COGGING}"));
    fitted(&folder.join(out))
}

#[test]
fn a_rig_that_cogs_renders_as_one_that_does_not_once_its_cogging_is_calibrated() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, &format!("calibrate cogging --out rig.toml {COGGING}"));
    let text = std::fs::read_to_string(folder.join("rig.toml")).unwrap();
    let calibration: toml::Table = text.parse().unwrap();
    let harmonics = calibration["motor_cogging"].as_array().unwrap();
    for (harmonic, (per_turn, torque_mnm)) in harmonics.iter().zip([(48, 1.4), (12, 0.6), (16, 0.3)]) {
        assert_eq!(harmonic["per_turn"].as_integer(), Some(per_turn), "{text}");
        assert!((harmonic["torque_mnm"].as_float().unwrap() - torque_mnm).abs() < 0.01, "{text}");
    }
    assert_eq!(harmonics.len(), 3);
    assert!(text.contains("# motor_cogging: 48 per turn of 1.4") && text.contains("± "), "{text}");

    // Without compensation the motor's teeth are felt beside the knob's detents.
    let (without, with) = (felt(folder, "without", ""), felt(folder, "with", "--calibration rig.toml"));
    let percent = |fit: &Value| fit["relative_error_percent"].as_f64().unwrap();
    println!(
        "the fit leaves {:.1} % of the torque without compensation, {:.1} % with it",
        percent(&without),
        percent(&with)
    );
    assert!(percent(&without) > 4.0 * percent(&with), "{} %, {} %", percent(&without), percent(&with));
    let detents = without["parameters"]["detent_amplitude"]["value"].as_f64().unwrap();
    assert!((detents / 1.1 - 1.0).abs() > 0.1, "the motor's torque is taken for detents: {detents} mNm");

    let verify = format!("replay 3 --verify --calibration rig.toml --json result.json {COGGING}");
    let said = errors(&call(folder, &verify));
    assert_eq!(
        said.matches("friction would drive").count(),
        1,
        "a remark is printed once, not for each capture: {said}"
    );
    let verified = json(&folder.join("result.json"));
    for parameter in verified["parameters"].as_array().unwrap() {
        assert_eq!(parameter["passed"], true, "{parameter}");
    }
    assert!(verified["torque_error_percent"].as_f64().unwrap() < 5.0, "{}", verified["torque_error_percent"]);
    assert!(verified["held_still"]["encoder_steps"].as_f64().unwrap() < 1.0, "{}", verified["held_still"]);
    assert_eq!((&verified["added"]["verdict"], &verified["passed"]), (&"none".into(), &true.into()));
}

#[test]
fn a_capture_does_not_show_the_cogging_of_the_motor_that_turns_the_knob() {
    // The torque sensor sits between motor and knob: what the magnets do to the rotor is the servo's trouble alone.
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    done(folder, &format!("capture --knob 3 --duration-s 10 --out out {COGGING}"));
    let fit = fitted(&folder.join("out"));
    let residual_mnm = fit["residual_rms_mnm"].as_f64().unwrap();
    println!("residual {residual_mnm} mNm");
    // Knob 3's friction and inertia, within its interval or 2 %.
    for (name, truth) in [("inertia", 0.035), ("coulomb_positive", 2.3), ("detent_amplitude", 1.1)] {
        let parameter = &fit["parameters"][name];
        let [value, low, high] =
            [&parameter["value"], &parameter["ci95"][0], &parameter["ci95"][1]].map(|number| number.as_f64().unwrap());
        assert!((low..=high).contains(&truth) || (value / truth - 1.0).abs() < 0.02, "{name}: {parameter}");
    }
    assert!(residual_mnm < 0.12, "a tenth of the weakest cogging would show: {residual_mnm} mNm");
}

#[test]
fn a_cogging_that_is_none_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    for wrong in ["48", "48:much", "-3:1", "48:1:2:3"] {
        let output = call(folder.path(), &format!("replay 3 --offline --motor-cogging={wrong}"));
        assert_eq!(output.status.code(), Some(2), "{wrong}");
        assert!(errors(&output).contains("as in 48:1.5:0.3"), "{wrong}");
    }
}
