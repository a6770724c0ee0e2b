//! Faults of a bus: each is reported once, the torque is gone within the watchdog, the archive is whole, and the next run starts.

use std::process::Child;

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use tests::ethercat::Port;
use tests::printed;

use super::{OURS, Running, Wired, ip};

/// AL status and its code (ETG.1000.4, 6.1.5).
const AL_STATUS: u16 = 0x0130;
const AL_STATUS_CODE: u16 = 0x0134;

/// Asserts that these words are in one line and no other.
fn reported_once(text: &str, words: &str) {
    assert_eq!(text.lines().filter(|line| line.contains(words)).count(), 1, "'{words}' in\n{text}");
}

/// Asserts that nothing is missing in the archive; ticks whose frame was lost are in it, and flagged.
fn is_whole(capture: Option<Capture>, text: &str) {
    let capture = capture.unwrap();
    assert!(capture.len() > 10 && capture.gaps.is_empty(), "{} samples, {text}", capture.len());
}

/// Asserts that a run ends in a fault reported in these words.
fn ends_in(wired: &Wired, words: &str) {
    let (said, status, capture) = wired.capture("1000", "5");
    assert_eq!(status, Some(1), "{said}");
    reported_once(&said, words);
    is_whole(capture, &said);
}

/// Starts a long run and waits until it has moved for a while.
fn moving(wired: &Wired) -> Child {
    let arguments =
        ["capture", "--rig", "rig.toml", "--rate-hz", "1000", "--duration-s", "20", "--no-viewer", "--out", "out"];
    let run = wired.bench.start(&arguments).unwrap();
    wired.segment.wait_for("AL 0x08");
    std::thread::sleep(std::time::Duration::from_secs(2));
    run
}

/// What a run said that ended in a fault, its archive whole.
fn ended(wired: &Wired, run: Child) -> String {
    let output = run.wait_with_output().unwrap();
    let said = printed(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    is_whole(Some(Capture::load(&wired.bench.only_archive("out").unwrap()).unwrap()), &said);
    said
}

/// Asserts that a further run does what it should.
fn next_run_starts(wired: &Wired) {
    let (said, status, capture) = wired.capture("1000", "1");
    assert_eq!(status, Some(0), "{said}");
    is_whole(capture, &said);
}

#[test]
fn a_drive_that_fails_is_reported_by_its_code() {
    let Some(mut wired) = Wired::new(&["--drive-error", "0x2310", "--after-s", "2"]) else { return };
    ends_in(&wired, "the rig 'servo': drive error 0x2310: continuous over current at the output");
    wired.segment = Running::start(&[]);
    next_run_starts(&wired);
}

#[test]
fn a_drive_that_is_switched_off_by_its_safety_input_is_distinguished_from_one_that_fails() {
    let Some(mut wired) = Wired::new(&["--safe-torque-off", "--after-s", "2"]) else { return };
    ends_in(&wired, "the drive switched itself off; check its safe-torque-off input");
    wired.segment = Running::start(&[]);
    next_run_starts(&wired);
}

#[test]
fn a_drive_that_goes_over_to_another_mode_ends_the_run() {
    let Some(wired) = Wired::new(&["--other-mode", "--after-s", "2"]) else { return };
    ends_in(&wired, "the drive left cyclic synchronous torque for another mode of operation");
}

#[test]
fn a_terminal_that_drops_out_shows_in_the_working_counter() {
    let Some(mut wired) = Wired::new(&["--terminal-absent", "--after-s", "2"]) else { return };
    ends_in(&wired, "a device no longer takes part in the exchange (wrong working counter)");
    // Less than is permitted is flagged, and the run goes on.
    wired.segment = Running::start(&["--terminal-absent", "--after-s", "2", "--frames", "20"]);
    let (said, status, capture) = wired.capture("1000", "4");
    assert_eq!(status, Some(0), "{said}");
    let words = "ticks without new data: a device no longer takes part in the exchange (wrong working counter)";
    reported_once(&said, words);
    let capture = capture.unwrap();
    let codes = &capture.description.as_ref().unwrap().device_codes;
    let counted = |words: &str| {
        let (code, _) = codes.iter().find(|(_, meaning)| meaning.contains(words)).unwrap();
        capture.rig.stale_samples.get(code).copied().unwrap_or(0)
    };
    // So many frames pass the terminal by; on a host that has other work some of them come back too late to be counted so.
    let (wrong, lost) = (counted("wrong working counter"), counted("frames no longer come back"));
    assert!(wrong > 0 && wrong <= 20 && wrong + lost >= 20, "{:?}", capture.rig);
    assert_eq!(capture.unmeasured_samples(), capture.rig.stale_samples.values().sum::<u64>());
}

#[test]
fn a_bus_that_stands_still_is_reported_and_the_drives_watchdog_takes_the_torque_away() {
    let Some(mut wired) = Wired::new(&[]) else { return };
    for signal in [Signal::SIGSTOP, Signal::SIGKILL] {
        let _ = std::fs::remove_dir_all(wired.bench.path("out"));
        let run = moving(&wired);
        wired.segment.signal(signal);
        reported_once(&ended(&wired, run), "frames no longer come back from the bus; check the cable");
        if signal == Signal::SIGSTOP {
            wired.segment.signal(Signal::SIGCONT);
            wired.segment.wait_for("AL 0x14 code 0x001b torque 0 mNm");
        } else {
            wired.segment = Running::start(&[]);
        }
        next_run_starts(&wired);
        wired.segment = Running::start(&[]);
    }
}

#[test]
fn a_link_that_goes_down_ends_the_run_and_the_next_one_starts_when_it_is_up() {
    let Some(wired) = Wired::new(&[]) else { return };
    let run = moving(&wired);
    assert!(ip(&format!("link set {OURS} down")));
    wired.segment.wait_for("AL 0x14 code 0x001b torque 0 mNm");
    reported_once(
        &ended(&wired, run),
        "the network interface takes no frames; check that it is up and its cable is in",
    );
    let (said, status, _) = wired.capture("1000", "1");
    assert_eq!(status, Some(1), "{said}");
    reported_once(&said, "hc0 takes no frames; bring it up");
    assert!(ip(&format!("link set {OURS} up")));
    next_run_starts(&wired);
}

#[test]
fn a_control_loop_that_is_killed_leaves_the_torque_to_the_drives_watchdog() {
    let Some(wired) = Wired::new(&[]) else { return };
    let run = moving(&wired);
    kill(wired.bench.wait_for_process("rt-loop").unwrap(), Signal::SIGKILL).unwrap();
    let state = wired.segment.wait_for("AL 0x14 code 0x001b torque 0 mNm");
    eprintln!("{state}");
    let port = Port::open(OURS).unwrap();
    let read = [port.read_register(AL_STATUS), port.read_register(AL_STATUS_CODE)];
    assert_eq!(read, [Some(0x14), Some(0x1b)], "read back over the wire");
    ended(&wired, run);
    next_run_starts(&wired);
}

#[test]
fn what_does_not_fit_is_refused_in_one_sentence_before_anything_moves() {
    let Some(mut wired) = Wired::new(&[]) else { return };
    let refused = |wired: &Wired, edit: &dyn Fn(String) -> String, words: &[&str]| {
        wired.rig(edit);
        let (said, status, capture) = wired.capture("1000", "1");
        assert_eq!(status, Some(1), "{said}");
        assert!(capture.is_none());
        words.iter().for_each(|words| reported_once(&said, words));
        assert_eq!(said.lines().count(), 2, "the status, and one sentence: {said}");
    };
    let replaced = |from: &'static str, to: &'static str| {
        move |text: String| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        }
    };
    refused(
        &wired,
        &replaced("product = 0x402", "product = 0x403"),
        &["no device is vendor 0xabcdef, product 0x403", "0 'HC-SERVO'"],
    );
    refused(
        &wired,
        &replaced("position = 1", "vendor = 0xabcdef"),
        &["2 devices are vendor 0xabcdef", "add `position`"],
    );
    refused(
        &wired,
        &replaced("\"0x603f:00/16\"", "\"0x7777:00/16\""),
        &["the device 'drive' does not take 0x77770010 (32 bits) for its object 0x1a00:04"],
    );
    refused(
        &wired,
        &replaced("sensor.0x6000:11", "sensor.0x6000:12"),
        &["the source 'sensor.0x6000:12' is not among the inputs of 'sensor': 0x6000:01/16, 0x6000:11/32"],
    );
    refused(
        &wired,
        &replaced("sensor.0x6000:11", "sensor torque"),
        &["the source 'sensor torque' is none of this driver's"],
    );
    refused(&wired, &replaced("\"0x6071:00/16\", ", ""), &["has no 0x6071:00 among its outputs"]);
    refused(
        &wired,
        &replaced("[settings.drive]\nvendor = 0xabcdef\nproduct = 0x402\n", "[settings.drive]\nposition = 1\n"),
        &["does not take"],
    );
    refused(
        &wired,
        &replaced("interface = \"hc0\"", "interface = \"hc9\""),
        &["the network interface hc9 cannot be used"],
    );
    wired.segment = Running::start(&["--no-watchdog"]);
    refused(&wired, &|text| text, &["'0 HC-SERVO' does not take a process-data watchdog of 0.5 s"]);
    wired.segment.signal(Signal::SIGKILL);
    refused(&wired, &|text| text, &["nothing answers on hc0; check the cable and the devices' supply"]);
}
