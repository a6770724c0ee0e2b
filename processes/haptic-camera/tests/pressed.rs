//! What is pressed: captured, fitted, told, rendered and judged in mm and N.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A damped button: a dome that collapses at 1 mm and bottoms out at 3.3 mm.
const BUTTON: &str = r#"name = "button"
axis = "linear"
[[effects]]
effect = "inertia"
inertia = 4e-6
[[effects]]
effect = "friction"
coulomb_negative = 0.02
coulomb_positive = 0.02
viscous_negative = 1e-3
viscous_positive = 1e-3
[[effects]]
effect = "return-spring"
spring_stiffness = 0.15
spring_centre = 0.0
[[effects]]
effect = "snap-through"
snap_height = 0.35
snap_flat_travel = 2.2
[[effects]]
effect = "bottom-out"
bottom_stiffness = 2.0
bottom_travel = 3.3
"#;

fn haptic_camera(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_haptic-camera"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn only(folder: &Path, ending: &str) -> PathBuf {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.into_iter().find(|path| path.extension().is_some_and(|found| found == ending)).unwrap()
}

#[test]
fn a_dome_is_captured_on_the_linear_rig_and_told_in_its_own_units() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let output = haptic_camera(folder, "capture --apparatus sim-linear --duration-s 4 --offline --no-viewer --out cap");
    assert!(output.status.success(), "{}", words(&output));
    let printed = words(&output);
    assert!(!printed.contains("mNm") && printed.contains("N s²/mm") && printed.contains("of the force"), "{printed}");
    let told: Value =
        serde_json::from_str(&std::fs::read_to_string(only(&folder.join("cap"), "json")).unwrap()).unwrap();
    let inertia = &told["parameters"]["inertia"];
    // Over several seeds half of the 95 % intervals miss it, by a third of their half width.
    assert!((inertia["value"].as_f64().unwrap() / 4e-6 - 1.0).abs() < 0.05, "{inertia}");
    assert_eq!(inertia["unit"], "N s²/mm");
    assert!(told["residual_rms_n"].as_f64().unwrap() < 0.005 && told["residual_rms_mnm"].is_null());
    let page = std::fs::read_to_string(only(&folder.join("cap"), "html")).unwrap();
    assert!(page.contains("travel (mm)") && !page.contains("mNm"), "a page in other units");

    let archive = only(&folder.join("cap"), "mcap");
    let output = haptic_camera(folder, &format!("export {} --out table.csv", archive.display()));
    assert!(output.status.success(), "{}", words(&output));
    let table = std::fs::read_to_string(folder.join("table.csv")).unwrap();
    assert!(table.starts_with("t_s,travel_mm,velocity_mm_s,acceleration_mm_s2,force_n\n"), "{}", &table[..80]);
    let again = haptic_camera(folder, "fit table.csv --json again.json");
    assert!(again.status.success(), "{}", words(&again));
    let again: Value = serde_json::from_str(&std::fs::read_to_string(folder.join("again.json")).unwrap()).unwrap();
    assert_eq!(again["parameters"]["inertia"]["value"], inertia["value"]);
}

#[test]
fn what_moves_along_the_other_axis_is_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in ["capture --apparatus sim-linear --knob 3 --offline", "capture --knob dome --offline"] {
        let output = haptic_camera(folder.path(), arguments);
        let printed = words(&output);
        assert_eq!(output.status.code(), Some(1), "{printed}");
        assert!(printed.contains("rotary") && printed.contains("linear"), "{printed}");
    }
}

#[test]
fn a_rendered_button_is_verified_as_knobs_are() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("button.toml"), BUTTON).unwrap();
    let arguments = "replay button.toml --nearest --apparatus sim-linear --verify --offline --out ver --json ver.json";
    let output = haptic_camera(folder.path(), arguments);
    assert!(output.status.success(), "{}", words(&output));
    assert!(!words(&output).contains("mNm"), "{}", words(&output));
}

#[test]
fn a_unit_is_turned_until_its_verdict_is_certain() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("wide.toml"), "[figures.collapse_force]\nmin = 0.3\nmax = 0.8\n").unwrap();
    std::fs::write(folder.join("low.toml"), "[figures.collapse_force]\nmax = 0.3\n").unwrap();
    for (spec, status) in [("wide.toml", 0), ("low.toml", 4)] {
        let output = haptic_camera(
            folder,
            &format!("capture --apparatus sim-linear --spec {spec} --offline --no-viewer --out out"),
        );
        assert_eq!(output.status.code(), Some(status), "{}", words(&output));
        assert!(words(&output).contains("after the first slow turn"), "{}", words(&output));
    }
}
