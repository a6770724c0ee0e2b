//! Captures from start to end, with all processes.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::time::Duration;

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tests::{Bench, printed};

/// Checks that the archive holds every sample: no gap in `seq`, and samples and missed ticks add up.
fn assert_whole(capture: &Capture, ticks: u64) {
    assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "seq runs without a gap");
    assert_eq!(capture.gaps, []);
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + first_tick(capture), ticks);
    assert_eq!(*capture.tick.last().unwrap(), ticks - 1, "the run goes on to its last tick");
}

/// Ticks missed before the first sample.
fn first_tick(capture: &Capture) -> u64 {
    capture.tick[0]
}

#[test]
fn a_capture_with_all_processes_ends_with_archive_model_and_report_and_leaves_nothing_behind() {
    let bench = Bench::new().unwrap();
    let output = bench.run(&["capture", "--knob", "3", "--duration-s", "6", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let archive = bench.only_archive("out").unwrap();
    assert_whole(&Capture::load(&archive).unwrap(), 60_000);
    assert!(archive.with_extension("toml").exists() && archive.with_extension("html").exists());
    let text = String::from_utf8_lossy(&output.stdout);
    for expected in ["inertia", "detent_period", "true", "archive", "report"] {
        assert!(text.contains(expected), "'{expected}' is missing in\n{text}");
    }
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_calibration_makes_its_run_as_a_capture_does_and_is_ended_as_one() {
    let bench = Bench::new().unwrap();
    let output = bench.run(&["calibrate", "zero", "--out", "rig.toml"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(bench.path("rig.toml").exists());
    let folder = std::fs::read_dir(bench.path("captures")).unwrap().next().unwrap().unwrap().path();
    assert_whole(&Capture::load(&folder.join("none.mcap")).unwrap(), 50_000);

    let child = bench.start(&["calibrate", "gravity", "--out", "gravity.toml"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(2));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(printed(&output).contains("stopped by the operator"), "{}", printed(&output));
    assert!(!bench.path("gravity.toml").exists());
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn standard_output_of_a_live_run_is_its_json_alone() {
    let bench = Bench::new().unwrap();
    std::fs::write(bench.path("rig.toml"), "name = \"bench\"\ndriver = \"simulated\"\n").unwrap();
    let output = bench.run(&["rig", "check", "rig.toml", "--duration-s", "1", "--json", "-"]).unwrap();
    let found: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&found["made_by"], &found["rig"]), (&"haptic-camera".into(), &"bench".into()), "{}", printed(&output));
}

#[test]
fn sixty_seconds_at_10_khz_are_recorded_without_a_gap() {
    let bench = Bench::new().unwrap();
    let output = bench.run(&["capture", "--duration-s", "60", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert_whole(&Capture::load(&bench.only_archive("out").unwrap()).unwrap(), 600_000);
}

#[test]
fn ten_seconds_at_20_khz_are_recorded_without_a_gap() {
    let bench = Bench::new().unwrap();
    let output =
        bench.run(&["capture", "--rate-hz", "20000", "--duration-s", "10", "--no-viewer", "--out", "out"]).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert_whole(&Capture::load(&bench.only_archive("out").unwrap()).unwrap(), 200_000);
}

#[test]
fn a_ctrl_c_brings_the_torque_down_and_leaves_a_whole_archive() {
    let bench = Bench::new().unwrap();
    let child = bench.start(&["capture", "--duration-s", "60", "--no-viewer", "--out", "out"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(4));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    let ticks = *capture.tick.last().unwrap() + 1;
    assert!((5_000..400_000).contains(&ticks), "{ticks} ticks");
    assert_whole(&capture, ticks);
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_ctrl_c_in_a_diagnosis_keeps_every_capture_whole() {
    let bench = Bench::new().unwrap();
    let arguments = ["capture", "--diagnose", "--knob", "2", "--duration-s", "6", "--no-viewer", "--out", "out"];
    let child = bench.start(&arguments).unwrap();
    let archives = || {
        let entries = std::fs::read_dir(bench.path("out")).into_iter().flatten().flatten().map(|entry| entry.path());
        entries.filter(|path| path.extension().is_some_and(|found| found == "mcap")).collect::<Vec<_>>()
    };
    let deadline = std::time::Instant::now() + Duration::from_secs(60);
    while archives().is_empty() && std::time::Instant::now() < deadline {
        std::thread::sleep(Duration::from_millis(50));
    }
    // In the middle of the second capture.
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(4));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let mut lengths = Vec::new();
    for path in archives() {
        let capture = Capture::load(&path).unwrap();
        let ticks = *capture.tick.last().unwrap() + 1;
        assert_whole(&capture, ticks);
        lengths.push(ticks);
    }
    lengths.sort_unstable();
    assert_eq!((lengths.len(), lengths[1]), (2, 60_000), "{lengths:?}");
    assert!(lengths[0] < 60_000, "{lengths:?}");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_ctrl_c_while_the_rig_rests_ends_the_command_at_once() {
    let bench = Bench::new().unwrap();
    let arguments = ["capture", "--diagnose", "--offline", "--knob", "2", "--duration-s", "6", "--out", "out"];
    let mut child = bench.start(&arguments).unwrap();
    let whole = || {
        let entries = std::fs::read_dir(bench.path("out")).into_iter().flatten().flatten();
        let captures = entries.filter_map(|entry| Capture::load(&entry.path()).ok());
        captures.filter(|capture| capture.tick.last() == Some(&59_999)).count()
    };
    while whole() < 2 {
        assert_eq!(child.try_wait().unwrap(), None, "two captures are made");
        std::thread::sleep(Duration::from_millis(50));
    }
    // The diagnosis of the two takes seconds.
    std::thread::sleep(Duration::from_millis(300));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(!printed(&output).contains("diagnosis.toml"), "{}", printed(&output));
    assert_eq!((whole(), bench.leftovers()), (2, Vec::new()));
}

#[test]
fn a_torque_sweep_on_a_knob_that_holds_is_measured_as_commanded() {
    let bench = Bench::new().unwrap();
    let arguments =
        ["capture", "--knob", "1", "--torque", "--amplitude", "30", "--duration-s", "3", "--no-viewer", "--out", "out"];
    let output = bench.run(&arguments).unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert_whole(&capture, 30_000);
    let commanded = capture.commanded_torque_mnm.unwrap();
    let difference: f64 = commanded.iter().zip(&capture.torque_mnm).map(|(c, m)| (c - m).powi(2)).sum();
    let rms = (difference / commanded.len() as f64).sqrt();
    // Knob 1 holds 150 mNm: motor and sensor are a locked gripper, less the motor's own friction of some 4 mNm.
    assert!(rms < 5.0, "{rms} mNm RMS between commanded and measured torque");
}

#[test]
fn a_knob_that_runs_away_ends_in_a_recorded_fault_and_exit_status_1() {
    let bench = Bench::new().unwrap();
    let arguments = ["capture", "--torque", "--amplitude", "60", "--duration-s", "5", "--no-viewer", "--out", "out"];
    let output = bench.run(&arguments).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert!(String::from_utf8_lossy(&output.stderr).contains("the speed exceeded the rig's limit"));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    let states = capture.state.unwrap();
    let (last, before) = states.split_last().unwrap();
    assert_eq!(*last, shared_types::LoopState::Fault.code());
    assert!(before.iter().all(|state| *state == shared_types::LoopState::Running.code()));
    assert_eq!(*capture.commanded_torque_mnm.unwrap().last().unwrap(), 0.0, "torque-free in the very sample");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn without_real_time_permission_a_capture_runs_all_the_same_and_is_marked() {
    let bench = Bench::new().unwrap();
    let plain = bench.command(&["capture", "--duration-s", "2", "--no-viewer", "--out", "out"]).unwrap();
    // Root without the capabilities that real time takes is like an ordinary user.
    let mut command = std::process::Command::new("setpriv");
    command.args(["--bounding-set", "-sys_nice,-ipc_lock,-sys_resource", "--"]).arg(plain.get_program());
    command.args(plain.get_args()).current_dir(plain.get_current_dir().unwrap());
    command.env(shared_types::rig::RUNTIME_DIR_VARIABLE, bench.path("rig"));
    let output = command.output().unwrap();
    assert!(matches!(output.status.code(), Some(0 | 3)), "{}", printed(&output));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(said.contains("without full real-time permission"), "{said}");
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    let granted = capture.description.unwrap().realtime;
    assert_eq!(granted & shared_types::realtime::FIFO, 0, "the archive says so");
}
