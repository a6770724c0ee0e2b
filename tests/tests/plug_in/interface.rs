//! Libraries that are none of ours, and the commands that an owner of a rig begins with.
#![allow(clippy::print_stderr, reason = "a test that skips says so")]

use hal::RigFile;
use tests::{Bench, printed};

use super::{compile, repository, rig};

/// A bench with a library made of `source` as the rig's; what `doctor --rig` says of it.
fn looked_at(source: &str) -> String {
    let bench = Bench::new().unwrap();
    std::fs::write(bench.path("other.c"), source).unwrap();
    compile(&bench, &bench.path("other.c"), "other.so");
    let file = rig(&bench, "", |text| text.replace("rotary_plant.so", "other.so"));
    let output = bench.run(&["capture", "--rig", &file, "--no-viewer"]).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(errors.lines().count(), 1, "{errors}");
    errors
}

#[test]
fn a_library_of_another_version_or_with_a_function_missing_is_refused() {
    let errors = looked_at("unsigned haptic_rig_abi(void) { return 7; }\n");
    assert!(errors.contains("has version 7 of haptic_rig.h, but this program takes version 1"), "{errors}");
    let errors = looked_at("unsigned haptic_rig_abi(void) { return 1; }\n");
    assert!(errors.contains("has no function `haptic_rig_open`"), "{errors}");
    let errors = looked_at("int nothing;\n");
    assert!(errors.contains("has no function `haptic_rig_abi`"), "{errors}");
}

#[test]
fn a_library_that_is_not_there_is_reported_with_its_path() {
    let bench = Bench::new().unwrap();
    let file = rig(&bench, "", |text| text.replace("rotary_plant.so", "nowhere.so"));
    let output = bench.run(&["capture", "--rig", &file, "--no-viewer"]).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("nowhere.so") && errors.contains("cannot be loaded"), "{errors}");
}

#[test]
fn a_new_rig_file_is_checked_and_commissioned() {
    let bench = Bench::new().unwrap();
    let output = bench.run(&["rig", "list"]).unwrap();
    assert!(printed(&output).contains("plugin  ") && printed(&output).contains("simulated  "), "{}", printed(&output));
    let output = bench.run(&["rig", "new", "--out", "mine.toml"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let header = std::fs::read_to_string(bench.path("haptic_rig.h")).unwrap();
    assert!(header.contains("#define HAPTIC_RIG_ABI 1u"));

    let file = rig(&bench, "", |text| text);
    let output =
        bench.run(&["rig", "check", &file, "--rate-hz", "5000", "--duration-s", "2", "--json", "check.json"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let found: serde_json::Value = serde_json::from_slice(&std::fs::read(bench.path("check.json")).unwrap()).unwrap();
    let noise = |index: usize| found["channels"][index]["noise_rms"].as_f64().unwrap();
    assert!((noise(1) - 0.25).abs() < 0.02, "the torque's noise is what the plant adds: {}", noise(1));
    assert!((noise(2) - 1.0).abs() < 0.08, "and the acceleration's: {}", noise(2));
    assert_eq!(found["watchdog"], "1 s, read back");

    // The rotor has 0.02 mNm·s²/rad and the knob 0.06.
    let output = bench.run(&["rig", "commission", &file, "--rate-hz", "5000"]).unwrap();
    let said = printed(&output);
    assert_eq!(output.status.code(), Some(0), "{said}");
    let number = |line: &str, place: usize| -> f64 {
        let line = said.lines().find(|found| found.starts_with(line)).unwrap();
        line.split_whitespace().nth(place).unwrap().parse().unwrap()
    };
    assert!((number("inertia", 1) - 0.08).abs() < 0.0016, "{said}");
    assert!((number("written", 3) - 0.02).abs() < 0.002, "{said}");
    let written = RigFile::load(&bench.path(&file)).unwrap().calibration().unwrap().unwrap();
    assert!((written.motor_inertia - 0.02).abs() < 0.002, "{written:?}");
    // The plant's encoder has 640,000 counts a turn.
    assert!((written.angle_step_rad - 9.817e-6).abs() < 1e-8, "{written:?}");
    for (sign, words) in
        [("motor_sign = -1.0", "[channels.motor] sign"), ("encoder_sign = -1.0", "[channels.angle] sign")]
    {
        let file = rig(&bench, sign, |text| text);
        let output = bench.run(&["rig", "commission", &file, "--rate-hz", "5000"]).unwrap();
        assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
        assert!(printed(&output).contains(words), "{}", printed(&output));
    }
}

#[test]
fn the_system_calls_that_a_rig_declares_are_counted_and_more_of_them_are_reported() {
    let bench = Bench::new().unwrap();
    let watched = |settings: &str, declared: &str| {
        let file = rig(&bench, settings, |text| format!("{text}\n{declared}\n"));
        let mut command = bench
            .command(&["capture", "--rig", &file, "--rate-hz", "1000", "--duration-s", "1", "--no-viewer"])
            .unwrap();
        let output = command.env("HAPTIC_CAMERA_WATCH_CALLS", "1").output().unwrap();
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let calling = |declared: &str| watched("calls = 2", declared);
    let errors = calling("[calls]\nnames = [\"getpid\"]\nper_tick = 2");
    if errors.contains("cannot be watched here") {
        eprintln!("SKIPPED: {errors}");
        return;
    }
    assert!(errors.contains("but its sleep and") && errors.contains("at most 2 in a tick"), "{errors}");
    let errors = calling("[calls]\nnames = [\"getpid\"]\nper_tick = 1");
    assert!(errors.contains("made 2 system calls in one tick, but its file permits 1"), "{errors}");
    let errors = calling("");
    assert!(errors.contains("system calls besides its sleep: getpid"), "{errors}");
    let errors = calling("[calls]\nnames = [\"teleport\"]\nper_tick = 1");
    assert!(errors.contains("an unknown system call 'teleport'"), "{errors}");
    compile(&bench, &repository().join("tests/tests/plug_in/ill_plant.c"), "rotary_plant.so");
    let errors = watched("ill = \"naps\"", "");
    assert!(errors.contains("system calls besides its sleep: clock_nanosleep"), "{errors}");
}
