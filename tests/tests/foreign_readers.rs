//! The archive of a real capture, read by programs of others, equals ours to the last bit.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::path::{Path, PathBuf};
use std::process::Command;

use archive::Capture;
use tests::{Bench, printed};

/// A Python with the packages that the readers need; says so when there is none.
#[allow(clippy::print_stderr, reason = "a test that skips says so")]
fn python_with(package: &str) -> Option<PathBuf> {
    let python = std::env::var_os("HAPTIC_CAMERA_PYTHON").map_or_else(|| PathBuf::from("python3"), PathBuf::from);
    let found = Command::new(&python).args(["-c", &format!("import {package}")]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: no Python with the package {package}; scripts/test installs it, HAPTIC_CAMERA_PYTHON names it");
    None
}

/// Captures for two seconds and gives the archive, with the columns as the readers are to write them.
fn captured(bench: &Bench) -> (PathBuf, Vec<u8>) {
    let output = bench.run(&["capture", "--duration-s", "2", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let path = bench.only_archive("out").unwrap();
    let capture = Capture::load(&path).unwrap();
    let columns = [
        &capture.angle_rad,
        capture.velocity_rad_s.as_ref().unwrap(),
        capture.acceleration_rad_s2.as_ref().unwrap(),
        &capture.torque_mnm,
        capture.commanded_angle_rad.as_ref().unwrap(),
        capture.commanded_torque_mnm.as_ref().unwrap(),
    ];
    let bytes = (0..capture.len()).flat_map(|row| columns.map(|column| column[row].to_le_bytes())).flatten().collect();
    (path, bytes)
}

fn reads_the_same(script: &str, package: &str) {
    let Some(python) = python_with(package) else { return };
    let bench = Bench::new().unwrap();
    let (archive, expected) = captured(&bench);
    let columns = bench.path("columns.bin");
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts").join(script);
    let output = Command::new(python).arg(script).arg(archive).arg(&columns).output().unwrap();
    assert!(output.status.success(), "{}", printed(&output));
    assert!(std::fs::read(columns).unwrap() == expected, "the columns differ");
}

#[test]
fn pythons_mcap_reader_with_the_ros_2_decoder_reads_every_value_to_the_last_bit() {
    reads_the_same("check-archive.py", "mcap_ros2");
}

#[test]
fn reruns_own_importer_reads_every_value_to_the_last_bit() {
    reads_the_same("check-archive-rerun.py", "rerun, datafusion");
}

#[test]
fn reruns_own_reader_finds_in_a_diagnosis_recording_what_its_json_tells() {
    let Some(python) = python_with("rerun, datafusion") else { return };
    let bench = Bench::new().unwrap();
    // A knob that lacks nothing and one that lacks an effect: drag of air.
    let drag = "[[effects]]\neffect = \"quadratic-drag\"\ndrag_coefficient = 0.05\n";
    for (effects, charts) in [("", 20), (drag, 20)] {
        let knob = format!(
            "name = \"test\"\ndescription = \"\"\n[[effects]]\neffect = \"inertia\"\ninertia = 0.05\n[[effects]]\n\
             effect = \"friction\"\ncoulomb_negative = 5.0\ncoulomb_positive = 5.5\nviscous_negative = 0.4\n\
             viscous_positive = 0.5\n{effects}"
        );
        std::fs::write(bench.path("knob.toml"), knob).unwrap();
        let arguments = "capture --diagnose --offline --knob knob.toml --rate-hz 4000 --duration-s 6 --out out --budget 2 \
                         --json diagnosis.json --recording diagnosis.rrd";
        let arguments: Vec<&str> = arguments.split_whitespace().collect();
        let output = bench.run(&arguments).unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/check-diagnosis-recording.py");
        let files = ["diagnosis.json", "diagnosis.rrd"].map(|name| bench.path(name));
        let output = Command::new(&python).arg(script).args(files).output().unwrap();
        assert!(output.status.success(), "{}", printed(&output));
        let output_text = String::from_utf8_lossy(&output.stdout).into_owned();
        let words: Vec<&str> = output_text.split_whitespace().collect();
        assert!(
            words[1].parse::<usize>().unwrap() >= charts && words[3].parse::<usize>().unwrap() > 1000,
            "{output_text}"
        );
    }
}
