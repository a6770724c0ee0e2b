//! Faults of the plant: each is reported once, with the library's own text, and the archive is whole.

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use shared_types::{Fault, rig as rig_folder};
use tests::{Bench, printed};

use super::{compile, repository, rig};

/// Captures with a fault; the error output, and the archive if there is one.
fn captured(bench: &Bench, settings: &str) -> (String, Option<Capture>) {
    let file = rig(bench, settings, |text| text);
    let _ = std::fs::remove_dir_all(bench.path("out"));
    let output = bench.run(&["capture", "--rig", &file, "--duration-s", "3", "--no-viewer", "--out", "out"]).unwrap();
    let said = printed(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let archive = bench.only_archive("out").ok().map(|archive| Capture::load(&archive).unwrap());
    (errors, archive)
}

/// Asserts that these words are in one line and no other.
fn reported_once(errors: &str, words: &str) {
    assert_eq!(errors.lines().filter(|line| line.contains(words)).count(), 1, "'{words}' in\n{errors}");
}

/// Asserts that nothing is missing in the archive, which ends in no torque.
fn is_whole(capture: Option<Capture>, errors: &str) {
    let capture = capture.unwrap();
    assert!(capture.len() > 10 && capture.gaps.is_empty(), "{} samples", capture.len());
    assert!(!errors.contains("are missing"), "{errors}");
}

#[test]
fn a_rig_that_refuses_to_switch_on_says_why() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"refuses\"");
    reported_once(&errors, "the rig 'rotary plant': code 12: the interlock is open; close the door");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    assert!(archive.is_none());
}

#[test]
fn a_rig_that_is_unplugged_in_a_run_is_reported_with_its_code_which_is_recorded() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"unplugged\"\nfault_s = 1.0");
    reported_once(&errors, "code 31: the card no longer answers; check its cable");
    is_whole(archive, &errors);
}

#[test]
fn a_stall_that_the_devices_watchdog_does_not_bear_is_reported_by_the_device() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"stalls\"\nfault_s = 1.0\nstall_s = 2.0");
    reported_once(&errors, "code 40: the watchdog ran out");
    is_whole(archive, &errors);
}

#[test]
fn a_value_that_is_no_number_ends_the_run() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"nan\"\nfault_s = 1.0");
    reported_once(&errors, "the rig 'rotary plant': a sensor gave a value that is not a number");
    is_whole(archive, &errors);
}

#[test]
fn a_motor_or_an_encoder_that_counts_the_wrong_way_round_is_distinguished_from_a_knob_that_lags() {
    let bench = Bench::new().unwrap();
    for sign in ["motor_sign = -1.0", "encoder_sign = -1.0"] {
        let (errors, _) = captured(&bench, sign);
        reported_once(&errors, &Fault::Runaway.to_string());
    }
}

#[test]
fn a_library_that_crashes_takes_the_control_loop_along_and_nothing_else() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"crashes\"\nfault_s = 1.0");
    reported_once(&errors, "it was killed by SIGSEGV), driving the rig 'rotary plant'");
    is_whole(archive, &errors);
}

#[test]
fn a_rig_that_does_not_come_back_from_a_call_is_given_up() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"blocks\"\nfault_s = 1.0");
    reported_once(&errors, "the rig 'rotary plant' does not return from a call");
    is_whole(archive, &errors);
}

#[test]
fn a_library_that_goes_wrong_is_reported_once_and_costs_no_sample() {
    let bench = Bench::new().unwrap();
    let source = repository().join("tests/tests/plug_in/ill_plant.c");
    compile(&bench, &source, "rotary_plant.so");
    let cases = [
        ("aborts", "it was killed by SIGABRT), driving the rig 'rotary plant'"),
        ("overflows", "it was killed by SIGSEGV), driving the rig 'rotary plant'"),
        ("exits", "its exit status is 0), driving the rig 'rotary plant'"),
        ("thread-aborts", "it was killed by SIGABRT), driving the rig 'rotary plant'"),
        ("infinite", "the rig 'rotary plant': a sensor gave a value that is not a number"),
        ("clock-back", "the rig 'rotary plant': the sensors delivered no new data"),
        ("clock-jumps", "the rig 'rotary plant': its own clock jumped by half a second or more"),
        ("angle-jumps", "the rig 'rotary plant': the angle jumped by more than a knob can turn"),
    ];
    for (ill, words) in cases {
        let (errors, archive) = captured(&bench, &format!("ill = \"{ill}\"\nfault_s = 1.0"));
        reported_once(&errors, words);
        is_whole(archive, &errors);
    }
}

#[test]
fn a_rig_that_does_not_come_back_from_switching_off_is_reported_and_the_capture_kept() {
    let bench = Bench::new().unwrap();
    compile(&bench, &repository().join("tests/tests/plug_in/ill_plant.c"), "rotary_plant.so");
    let (said, archive) = captured(&bench, "ill = \"blocks-in-disable\"");
    reported_once(&said, "the rig 'rotary plant' does not return from a call");
    is_whole(archive, &said);
}

#[test]
fn a_preparation_that_never_ends_is_given_up_when_the_run_is_stopped() {
    let bench = Bench::new().unwrap();
    compile(&bench, &repository().join("tests/tests/plug_in/ill_plant.c"), "rotary_plant.so");
    let file = rig(&bench, "ill = \"blocks-in-prepare\"", |text| text);
    let child = bench.start(&["capture", "--rig", &file, "--duration-s", "3", "--no-viewer"]).unwrap();
    bench.wait_for_process("rt-loop").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(2500));
    kill(Pid::from_raw(child.id().cast_signed()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    reported_once(&said, "waiting for the rig 'rotary plant' to come up");
    reported_once(&said, "does not return from its preparation");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_watchdog_that_reads_back_slower_than_the_file_asks_is_refused() {
    let bench = Bench::new().unwrap();
    let (errors, archive) = captured(&bench, "fault = \"slow-watchdog\"");
    reported_once(&errors, "reads back longer than [watchdog] timeout_s");
    assert!(archive.is_none());
}

#[test]
fn a_rig_that_takes_its_time_to_come_up_can_be_stopped_meanwhile() {
    let bench = Bench::new().unwrap();
    let file = rig(&bench, "fault = \"slow-start\"", |text| text);
    let child = bench.start(&["capture", "--rig", &file, "--duration-s", "3", "--no-viewer"]).unwrap();
    bench.wait_for_process("rt-loop").unwrap();
    std::thread::sleep(std::time::Duration::from_millis(500));
    kill(Pid::from_raw(child.id().cast_signed()), Signal::SIGINT).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    reported_once(&String::from_utf8_lossy(&output.stderr), "stopped before the run began");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn two_runs_do_not_share_a_device_whatever_their_runtime_folders() {
    let bench = Bench::new().unwrap();
    let file = rig(&bench, "", |text| text);
    let arguments = ["capture", "--rig", &file, "--duration-s", "5", "--no-viewer", "--out"];
    let first = bench.start(&[&arguments[..], &["first"]].concat()).unwrap();
    bench.wait_for_process("recorder").unwrap();
    let mut second = bench.command(&[&arguments[..], &["second"]].concat()).unwrap();
    let elsewhere = bench.path("elsewhere");
    let second = second.env(rig_folder::RUNTIME_DIR_VARIABLE, elsewhere).output().unwrap();
    assert_eq!(second.status.code(), Some(1), "{}", printed(&second));
    let errors = String::from_utf8_lossy(&second.stderr).into_owned();
    reported_once(&errors, "the rig 'rotary plant' is in use: another run holds its device");
    let first = first.wait_with_output().unwrap();
    assert_eq!(first.status.code(), Some(0), "{}", printed(&first));
}

#[test]
fn what_belongs_to_the_simulated_rig_is_refused_for_others() {
    let bench = Bench::new().unwrap();
    let file = rig(&bench, "", |text| text);
    let refused: [(&[&str], &str); 4] = [
        (&["capture", "--rig", &file, "--seed", "3"], "--seed only applies to the simulated rig"),
        (&["capture", "--rig", &file, "--motor-cogging", "48:1"], "--motor-cogging only applies to the simulated rig"),
        (&["capture", "--rig", &file, "--offline"], "omit --offline"),
        (
            &["replay", "3", "--rig", &file, "--hand", "multisine", "--duration-s", "1"],
            "only applies to the simulated rig",
        ),
    ];
    for (arguments, words) in refused {
        let output = bench.run(&[arguments, &["--no-viewer"]].concat()).unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}: {}", printed(&output));
        reported_once(&String::from_utf8_lossy(&output.stderr), words);
    }
}

#[test]
fn a_rig_file_with_a_key_that_none_has_is_refused_with_its_line() {
    let bench = Bench::new().unwrap();
    let file = rig(&bench, "", |text| text.replace("speed_rad_s", "velocity_rad_s"));
    let output = bench.run(&["doctor", "--rig", &file]).unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let output = bench.run(&["capture", "--rig", &file, "--no-viewer"]).unwrap();
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    reported_once(&errors, "rig.toml: line");
    assert!(errors.contains("unknown field `velocity_rad_s`"), "{errors}");
    assert!(repository().join("hal/src/simulated_rig/rig.toml").exists());
}
