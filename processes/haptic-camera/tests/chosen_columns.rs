//! Files whose columns are named on the command line are captures like any other.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use archive::Capture;

fn run(arguments: &[&str], folder: &Path) -> Output {
    Command::new(env!("CARGO_BIN_EXE_haptic-camera")).args(arguments).current_dir(folder).output().unwrap()
}

/// Time, angle and torque of a capture as our own table and as somebody else's.
fn tables(capture: &Capture) -> [String; 2] {
    let [mut own, mut foreign] = ["t_s,angle_rad,torque_mnm\n", "Zeit;Winkel;Moment\n"].map(str::to_owned);
    for ((t_s, angle_rad), torque_mnm) in capture.t_s.iter().zip(&capture.angle_rad).zip(&capture.torque_mnm) {
        writeln!(own, "{t_s},{angle_rad},{torque_mnm}").unwrap();
        writeln!(foreign, "{};{};{}", 1e3 * t_s, angle_rad.to_degrees(), 0.1 * torque_mnm).unwrap();
    }
    [own, foreign]
}

#[test]
fn a_table_with_named_columns_is_fitted_diagnosed_and_exported_as_a_capture() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        let output = run(arguments, folder.path());
        assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        output
    };
    run(&["capture", "--knob", "3", "--duration-s", "4", "--offline", "--no-viewer", "--out", "made"]);
    let archive = std::fs::read_dir(folder.path().join("made")).unwrap().map(|entry| entry.unwrap().path());
    let archive = {
        let mut archives = archive.filter(|path| path.extension().is_some_and(|ending| ending == "mcap"));
        archives.next().unwrap()
    };
    let capture = Capture::load(&archive).unwrap();
    for (name, text) in ["own.csv", "bench.csv"].iter().zip(tables(&capture)) {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let named = ["--columns", "angle=Winkel,torque=Moment,time=Zeit", "--units", "angle=deg,torque=Ncm,time=ms"];
    run(&["fit", "own.csv", "--json", "own.json"]);
    run(&[&["fit", "bench.csv", "--json", "bench.json"][..], &named].concat());
    let inertia = |name: &str| {
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(folder.path().join(name)).unwrap()).unwrap();
        json["parameters"]["inertia"]["value"].as_f64().unwrap()
    };
    assert!((inertia("bench.json") / inertia("own.json") - 1.0).abs() < 1e-6);
    run(&[&["export", "bench.csv", "--out", "again.csv"][..], &named].concat());
    let again = Capture::load(&folder.path().join("again.csv")).unwrap();
    let same = |found: &[f64], own: &[f64]| found.iter().zip(own).all(|(found, own)| (found - own).abs() < 1e-9);
    assert!(again.len() == capture.len() && same(&again.angle_rad, &capture.angle_rad));
    assert!(same(&again.torque_mnm, &capture.torque_mnm) && same(&again.t_s, &capture.t_s));

    // Without its time it is no capture, and that is said.
    let timeless = ["--columns", "angle=Winkel,torque=Moment", "--units", "angle=deg,torque=Ncm"];
    let refused = self::run(&[&["diagnose", "bench.csv"][..], &timeless].concat(), folder.path());
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(1));
    assert!(said.contains("bench.csv has no time, so it is a curve and not a capture"), "{said}");
}
