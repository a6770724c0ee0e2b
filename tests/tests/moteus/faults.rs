//! What goes wrong with a controller: told once, by its name, torque gone, the archive whole, and the next run begins.

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use tests::{Bench, printed};

use super::{Server, rig};

/// A capture of three seconds; what was told.
fn told(bench: &Bench, file: &str) -> String {
    let _ = std::fs::remove_dir_all(bench.path("out"));
    let output =
        bench.run(&["capture", "--rig", file, "--rate-hz", "1000", "--duration-s", "3", "--no-viewer", "--out", "out"]);
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    assert_eq!(bench.leftovers(), Vec::<String>::new());
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn told_once(told: &str, words: &str) {
    assert_eq!(told.lines().filter(|line| line.contains(words)).count(), 1, "'{words}' in\n{told}");
}

/// Asserts that nothing is missing in the archive.
fn is_whole(bench: &Bench, told: &str) {
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert!(capture.len() > 10 && capture.gaps.is_empty(), "{} samples", capture.len());
    assert!(!told.contains("are missing"), "{told}");
}

/// Asserts that a run on a sound controller at the same port begins and ends well.
fn the_next_run_begins(bench: &Bench, file: &str) {
    let _server = Server::start(bench, &[]);
    let _ = std::fs::remove_dir_all(bench.path("out"));
    let output =
        bench.run(&["capture", "--rig", file, "--rate-hz", "1000", "--duration-s", "1", "--no-viewer", "--out", "out"]);
    let output = output.unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}

/// A run into this trouble is told in these words; the controller's torque goes, and the run after it begins.
fn ends_with(trouble: &[&str], words: &str) {
    let bench = Bench::new().unwrap();
    let server = Server::start(&bench, trouble);
    let file = rig(&bench, |text| text);
    let told = told(&bench, &file);
    told_once(&told, words);
    is_whole(&bench, &told);
    // Stopped by command, by its own fault, or by its watchdog.
    std::thread::sleep(std::time::Duration::from_millis(1500));
    let events = server.told();
    let last_mode = events.iter().rev().find_map(|line| line.strip_prefix("mode "));
    assert!(matches!(last_mode, Some("0" | "11")), "the motor is on: {events:?}");
    drop(server);
    the_next_run_begins(&bench, &file);
}

#[test]
fn a_fault_of_the_controllers_own_is_told_by_its_code() {
    ends_with(&["--trouble", "driver-fault"], "fault code 33: motor driver fault");
}

#[test]
fn a_controller_that_falls_silent_is_told() {
    ends_with(&["--trouble", "silence"], "the controller does not answer");
}

#[test]
fn garbage_instead_of_answers_is_told() {
    ends_with(&["--trouble", "garbage"], "what came from the port is no answer");
}

#[test]
fn wrong_checksums_are_told() {
    ends_with(&["--uart", "--trouble", "checksum"], "answers came with wrong checksums");
}

#[test]
fn a_controller_that_is_switched_off_and_on_in_a_run_is_told() {
    ends_with(&["--trouble", "restart"], "the controller began anew");
}

#[test]
fn a_port_that_goes_in_a_run_is_told() {
    let bench = Bench::new().unwrap();
    let mut server = Server::start(&bench, &[]);
    let file = rig(&bench, |text| text);
    let arguments =
        ["capture", "--rig", &file, "--rate-hz", "1000", "--duration-s", "3", "--no-viewer", "--out", "out"];
    let child = bench.start(&arguments).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    server.kill();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    told_once(&told, "its port is gone, or its CAN interface is down; check the cable");
    is_whole(&bench, &told);
    the_next_run_begins(&bench, &file);
}

#[test]
fn a_control_loop_that_is_killed_leaves_no_torque_beyond_the_watchdogs_time() {
    let bench = Bench::new().unwrap();
    let server = Server::start(&bench, &[]);
    let file = rig(&bench, |text| text.replace("timeout_s = 1.0 ", "timeout_s = 0.2 "));
    let arguments =
        ["capture", "--rig", &file, "--rate-hz", "1000", "--duration-s", "5", "--no-viewer", "--out", "out"];
    let child = bench.start(&arguments).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(1500));
    server.told();
    kill(bench.wait_for_process("rt-loop").unwrap(), Signal::SIGKILL).unwrap();
    assert_eq!(server.line("timeout").as_deref(), Some("timeout 0.2000 s after the last command"));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    is_whole(&bench, &String::from_utf8_lossy(&output.stderr));
    drop(server);
    the_next_run_begins(&bench, &file);
}

#[test]
fn a_controller_that_cannot_be_driven_is_told_before_the_run() {
    let cases: [(&[&str], &str); 3] = [
        (&["--trouble", "unconfigured"], "fault code 36: motor not configured"),
        (&["--trouble", "no-watchdog"], "the controller goes on driving without commands"),
        (&["--trouble", "slow"], "answers take too long"),
    ];
    for (trouble, words) in cases {
        let bench = Bench::new().unwrap();
        let server = Server::start(&bench, &[]);
        let file = rig(&bench, |text| text);
        drop(server);
        let _server = Server::start(&bench, trouble);
        let told = told(&bench, &file);
        told_once(&told, words);
        assert!(bench.only_archive("out").is_err(), "{told}");
    }
}

#[test]
fn a_port_without_a_controller_is_told_and_its_preparation_can_be_stopped() {
    let bench = Bench::new().unwrap();
    let _server = Server::start(&bench, &[]);
    let file = rig(&bench, |text| text.replace("\nid = 1\n", "\nid = 7\n"));
    told_once(&told(&bench, &file), "the controller does not answer; check its supply, its cable and [settings] id");
    let file = rig(&bench, |text| text.replace("port = \"", "port = \"/nowhere"));
    told_once(&told(&bench, &file), "which is neither a tty nor a CAN interface of this machine");
}
