//! Whatever becomes of the processes of a run: what was planned, taken and archived adds up, or the difference is reported.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::time::Duration;

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use tests::{Bench, StoppedThread, printed};

/// A capture of so many seconds whose recorder is at work.
fn start(bench: &Bench, duration_s: &str) -> Child {
    let child = bench.start(&["capture", "--duration-s", duration_s, "--no-viewer", "--out", "out"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_millis(1_500));
    child
}

/// The archive of a capture that ended with this status.
fn ended(bench: &Bench, child: Child, status: i32) -> (Capture, Output) {
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert_eq!(bench.leftovers(), Vec::<String>::new());
    (capture, output)
}

/// Ticks that the archive accounts for, from the first on.
fn ticks(capture: &Capture) -> u64 {
    capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0]
}

fn assert_whole(capture: &Capture, planned: u64) {
    assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "no sample is missing");
    assert_eq!(capture.gaps, []);
    assert_eq!(ticks(capture), planned);
}

/// Samples that the run took, as printed for the operator.
fn reported_samples(output: &Output) -> u64 {
    let said = printed(output);
    let line = said.lines().find(|line| line.starts_with("samples  ")).unwrap().to_owned();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

/// Asserts that an archive has gaps, and that all of them are reported and are all that is missing.
fn assert_gaps_are_reported(capture: &Capture, output: &Output) {
    assert!(!capture.gaps.is_empty());
    let missing = capture.lost_samples();
    assert_eq!(capture.len() as u64 + missing, reported_samples(output), "kept and missing are all there were");
    for gap in &capture.gaps {
        assert!(printed(output).contains(&gap.to_string()), "{gap} is not in {}", printed(output));
    }
}

#[test]
fn a_recorder_that_somebody_asks_to_end_loses_nothing() {
    for signal in [Signal::SIGTERM, Signal::SIGHUP, Signal::SIGINT] {
        let bench = Bench::new().unwrap();
        let child = start(&bench, "4");
        kill(bench.wait_for_process("recorder").unwrap(), signal).unwrap();
        assert_whole(&ended(&bench, child, 0).0, 40_000);
    }
}

#[test]
fn a_control_loop_that_somebody_asks_to_end_leaves_a_whole_archive_and_what_is_short_of_the_plan_is_reported() {
    for signal in [Signal::SIGTERM, Signal::SIGHUP] {
        let bench = Bench::new().unwrap();
        let child = start(&bench, "6");
        kill(bench.wait_for_process("rt-loop").unwrap(), signal).unwrap();
        let (capture, output) = ended(&bench, child, 3);
        let come_to = ticks(&capture);
        assert_whole(&capture, come_to);
        assert!(come_to < 60_000);
        let expected = format!("after {come_to} of 60000 ticks: ticks {come_to} to 59999 ({})", 60_000 - come_to);
        assert!(printed(&output).contains(&expected), "{expected} is missing in {}", printed(&output));
    }
}

#[test]
fn a_publisher_without_a_processor_over_the_end_of_the_run_loses_nothing_that_the_ring_holds() {
    let bench = Bench::new().unwrap();
    let child = start(&bench, "9");
    let Some(publisher) = StoppedThread::stop(bench.wait_for_process("rt-loop").unwrap()) else {
        return drop(child.wait_with_output());
    };
    std::thread::sleep(Duration::from_secs(9));
    drop(publisher);
    assert_whole(&ended(&bench, child, 0).0, 90_000);
}

#[test]
fn what_the_ring_cannot_hold_at_the_end_of_the_run_is_a_gap_that_is_reported() {
    let bench = Bench::new().unwrap();
    let child = start(&bench, "20");
    let Some(publisher) = StoppedThread::stop(bench.wait_for_process("rt-loop").unwrap()) else {
        return drop(child.wait_with_output());
    };
    // The supervisor too, which would give up a control loop that says nothing for so long.
    let supervisor = bench.wait_for_process("haptic-camera").unwrap();
    kill(supervisor, Signal::SIGSTOP).unwrap();
    std::thread::sleep(Duration::from_secs(20));
    drop(publisher);
    std::thread::sleep(Duration::from_millis(700));
    kill(supervisor, Signal::SIGCONT).unwrap();
    let (capture, output) = ended(&bench, child, 3);
    assert_gaps_are_reported(&capture, &output);
    assert!(printed(&output).contains("were taken but not published"), "{}", printed(&output));
    let missing = capture.lost_samples();
    assert_eq!(
        capture.gaps.last().unwrap().last_missing_seq,
        reported_samples(&output) - 1,
        "the end is what is missing"
    );
    assert!(ticks(&capture) + missing <= 200_000);
}

/// The programs of the instrument in a folder of the bench's own, so that one can be taken away.
struct Programs(PathBuf);

impl Programs {
    fn copied(bench: &Bench) -> Self {
        let folder = bench.path("programs");
        std::fs::create_dir(&folder).unwrap();
        for name in ["haptic-camera", "rt-loop", "recorder", "live-fitter"] {
            std::fs::copy(tests::program(name).unwrap(), folder.join(name)).unwrap();
        }
        Self(folder)
    }

    /// Starts a capture with these programs.
    fn start(&self, bench: &Bench, duration_s: &str) -> Child {
        let arguments = ["capture", "--duration-s", duration_s, "--no-viewer", "--out", "out"];
        let plain = bench.command(&arguments).unwrap();
        let mut command = Command::new(self.0.join("haptic-camera"));
        command.args(plain.get_args()).current_dir(plain.get_current_dir().unwrap());
        command.env(shared_types::rig::RUNTIME_DIR_VARIABLE, bench.path("rig"));
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap()
    }

    /// A capture of so many seconds whose recorder is at work.
    fn start_and_wait(&self, bench: &Bench, duration_s: &str) -> Child {
        let child = self.start(bench, duration_s);
        bench.wait_for_process("recorder").unwrap();
        std::thread::sleep(Duration::from_millis(1_500));
        child
    }

    fn take_away(&self, name: &str) {
        std::fs::rename(self.0.join(name), self.aside(name)).unwrap();
    }

    fn put_back(&self, name: &str) {
        std::fs::rename(self.aside(name), self.0.join(name)).unwrap();
    }

    fn aside(&self, name: &str) -> PathBuf {
        self.0.join(format!("{name}.aside"))
    }

    /// Puts a shell script in a program's place.
    fn replace(&self, name: &str, script: &str) {
        write_script(&self.0.join(format!("{name}.new")), script);
        std::fs::rename(self.0.join(format!("{name}.new")), self.0.join(name)).unwrap();
    }
}

fn write_script(path: &Path, script: &str) {
    std::fs::write(path, format!("#!/bin/sh\n{script}\n")).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o700)).unwrap();
}

#[test]
fn a_recorder_whose_program_is_missing_and_then_dies_at_once_is_back_without_a_gap() {
    let bench = Bench::new().unwrap();
    let programs = Programs::copied(&bench);
    let child = programs.start_and_wait(&bench, "10");
    programs.take_away("recorder");
    bench.kill("recorder").unwrap();
    std::thread::sleep(Duration::from_millis(400));
    programs.replace("recorder", "exit 1");
    std::thread::sleep(Duration::from_millis(2_500));
    programs.put_back("recorder");
    let (capture, output) = ended(&bench, child, 0);
    assert_whole(&capture, 100_000);
    assert!(printed(&output).contains("recorder cannot be started"), "{}", printed(&output));
}

#[test]
fn a_recorder_that_was_away_for_longer_than_the_stream_remembers_costs_what_is_reported_and_no_more() {
    let bench = Bench::new().unwrap();
    let programs = Programs::copied(&bench);
    let child = programs.start_and_wait(&bench, "17");
    programs.take_away("recorder");
    bench.kill("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(12));
    programs.put_back("recorder");
    let (capture, output) = ended(&bench, child, 3);
    assert_gaps_are_reported(&capture, &output);
    assert_eq!(capture.tick.last(), Some(&169_999), "it is back before the end");
    assert!(printed(&output).contains("samples lost while there was no recorder"), "{}", printed(&output));
}

#[test]
fn a_control_loop_that_dies_before_it_is_ready_is_reported() {
    let bench = Bench::new().unwrap();
    let programs = Programs::copied(&bench);
    programs.replace("rt-loop", "kill -BUS $$");
    let output = programs.start(&bench, "2").wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let said = printed(&output);
    assert!(said.contains("the control loop ended before it was ready (it was killed by SIGBUS)"), "{said}");
}
