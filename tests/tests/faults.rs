//! Processes that die, and what the capture makes of it.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::time::Duration;

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use tests::trials::{Fault, Trial, Victim};
use tests::{Bench, printed};

/// Kills `victim` ten times in a capture, at irregular moments, and checks the archive.
fn survives_ten_kills_of(victim: &str) {
    let bench = Bench::new().unwrap();
    let mut arguments = vec!["capture", "--duration-s", "14", "--out", "out"];
    if victim != "rerun-viewer" {
        arguments.push("--no-viewer");
    }
    let child = bench.start(&arguments).unwrap();
    bench.wait_for_process(victim).unwrap();
    std::thread::sleep(Duration::from_millis(1_500));
    let mut killed = Vec::new();
    for round in 0..10_u64 {
        let pid = bench.wait_for_process(victim).unwrap();
        kill(pid, Signal::SIGKILL).unwrap();
        killed.push(pid);
        std::thread::sleep(Duration::from_millis(700 + 137 * (round * 7 % 5)));
    }
    killed.dedup();
    assert_eq!(killed.len(), 10, "ten different processes were killed");
    bench.wait_for_process(victim).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(text.contains(&format!("{victim} died and was restarted 10 times")), "{text}");
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "no sample is missing");
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], 140_000);
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_recorder_killed_ten_times_leaves_one_archive_without_a_gap() {
    survives_ten_kills_of("recorder");
}

#[test]
fn a_live_fitter_killed_ten_times_costs_no_sample() {
    survives_ten_kills_of("live-fitter");
}

#[test]
fn a_viewer_killed_ten_times_costs_no_sample() {
    survives_ten_kills_of("rerun-viewer");
}

/// Makes one trial whose moment is always the same, and expects every promise to be kept.
fn keeps_its_promises(victim: Victim, fault: Fault) {
    let outcome = Trial::of_kind(victim, fault, 7).run(&Bench::new().unwrap()).unwrap();
    assert_eq!(outcome.broken, Vec::<String>::new());
    assert_eq!((outcome.lost_samples, outcome.lost_unsaid, outcome.orphans), (0, 0, 0));
}

#[test]
fn a_recorder_that_hangs_is_replaced_before_a_sample_is_lost() {
    keeps_its_promises(Victim::Recorder, Fault::Stopped);
}

#[test]
fn a_control_loop_that_was_stopped_ends_in_a_fault_and_a_whole_archive() {
    keeps_its_promises(Victim::ControlLoop, Fault::Stopped);
}

#[test]
fn a_panic_on_the_real_time_thread_ends_the_run_and_nothing_else() {
    keeps_its_promises(Victim::ControlLoop, Fault::PanicInRealTime);
}

#[test]
fn a_panic_of_the_publisher_ends_the_run_and_nothing_else() {
    keeps_its_promises(Victim::ControlLoop, Fault::Panic);
}

#[test]
fn a_killed_control_loop_is_reported_and_a_new_capture_starts_at_once() {
    keeps_its_promises(Victim::ControlLoop, Fault::Killed);
}

#[test]
fn a_killed_supervisor_takes_its_processes_with_it_and_the_archive_is_whole() {
    keeps_its_promises(Victim::Supervisor, Fault::Killed);
}
