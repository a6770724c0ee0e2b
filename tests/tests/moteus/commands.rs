//! The commands that an owner of a controller begins with, and what a tick costs.

use tests::{Bench, printed};

use super::{Server, rig, with_sensor};

#[test]
fn a_controller_is_found_by_its_identifier_and_a_rig_file_written() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &["--id", "42"]);
    let port = bench.path("port");
    let output = bench.run(&["rig", "scan", &port.to_string_lossy(), "--out", "found.toml"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(printed(&output).contains("moteus 42"), "{}", printed(&output));
    let output = bench.run(&["doctor", "--rig", "found.toml"]).unwrap();
    assert!(printed(&output).contains("is available"), "{}", printed(&output));
}

#[test]
fn a_port_on_which_nobody_answers_is_told() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &["--id", "42", "--trouble", "silence", "--after", "0"]);
    let output = bench.run(&["rig", "scan", "/dev/null", "--out", "found.toml"]).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(!bench.path("found.toml").exists());
}

#[test]
fn a_new_controller_is_checked_and_commissioned() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &[]);
    let file = rig(&bench, |text| text);
    let output = bench.run(&["rig", "check", &file, "--duration-s", "2"]).unwrap();
    // Whether the rate is held is the machine's.
    for words in ["watchdog 1 s, read back", "angle", "µs after the tick"] {
        assert!(printed(&output).contains(words), "{}", printed(&output));
    }
    let output = bench.run(&["rig", "commission", &file]).unwrap();
    // Whether the interval is narrow is the machine's too.
    assert!(printed(&output).contains("in total, driven by the motor"), "{}", printed(&output));
}

#[test]
fn a_calibration_counts_the_rotor_once() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &[]);
    let file = rig(&bench, |text| text);
    let line = |text: &str| text.lines().find(|line| line.starts_with("gripper_inertia")).unwrap().to_owned();
    let number = |line: &str| -> f64 { line.split(['=', '#']).nth(1).unwrap().trim().parse().unwrap() };
    let of_rig = number(&line(&std::fs::read_to_string(bench.path(&file)).unwrap()));
    let calibrate =
        ["calibrate", "zero", "--rig", &file, "--rate-hz", "500", "--out", "known.toml", "--captures-in", "captures"];
    for again in [&[][..], &["--calibration", "known.toml"]] {
        let output = bench.run(&[&calibrate[..], again].concat()).unwrap();
        assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
        let known = std::fs::read_to_string(bench.path("known.toml")).unwrap();
        assert!((number(&line(&known)) - of_rig).abs() < 1e-12, "{known}");
    }
}

#[test]
fn what_an_owner_captured_can_be_replayed_where_there_is_a_torque_sensor() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &[]);
    let calibrated = |text: String| {
        with_sensor(&text)
            .replace("gripper_inertia = 0.0 ", "motor_coulomb_mnm = 0.0\nmotor_viscous = 0.0\ngripper_inertia = 0.06 ")
    };
    let file = rig(&bench, calibrated);
    let output = bench
        .run(&["replay", "2", "--nearest", "--rig", &file, "--rate-hz", "1000", "--duration-s", "2", "--no-viewer"])
        .unwrap();
    eprintln!("{}", printed(&output));
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let late =
        |text: String| calibrated(text).replace("motor_viscous = 0.0", "motor_viscous = 0.0\ncommand_delay_s = 9.5e-3");
    let file = rig(&bench, late);
    let output = bench
        .run(&["replay", "2", "--nearest", "--rig", &file, "--rate-hz", "1000", "--duration-s", "2", "--no-viewer"])
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(printed(&output).contains("cannot render a knob stably in a hand"), "{}", printed(&output));
    let file = rig(&bench, |text| text);
    let output = bench
        .run(&["replay", "2", "--nearest", "--rig", &file, "--rate-hz", "1000", "--duration-s", "2", "--no-viewer"])
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(printed(&output).contains("has no torque sensor"), "{}", printed(&output));
}

#[test]
fn a_tick_makes_no_system_call_that_the_driver_does_not_declare() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &[]);
    let file = rig(&bench, |text| text);
    let mut command =
        bench.command(&["capture", "--rig", &file, "--rate-hz", "800", "--duration-s", "2", "--no-viewer"]).unwrap();
    let output = command.env("HAPTIC_CAMERA_WATCH_CALLS", "1").output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    if told.contains("cannot be watched here") {
        eprintln!("SKIPPED: {told}");
        return;
    }
    eprintln!("{told}");
    // That there are no more of them than it declares the loop looks after itself.
    assert!(told.contains("no system call but its sleep and") && told.contains("that the rig declares"), "{told}");
}
