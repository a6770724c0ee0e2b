//! Every process of a run ends with the one that started it, and a run ends in order when its terminal does.
#![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

use std::process::{Command, Stdio};
use std::time::Duration;

use archive::Capture;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use tests::Bench;
use tests::trials::EarlyKills;

#[test]
fn supervisors_killed_within_their_first_moments_leave_no_process_behind() {
    let bench = Bench::new().unwrap();
    let kills = EarlyKills { kills: 60, latest: Duration::from_millis(50), seed: 7 };
    assert_eq!(kills.orphans(&bench).unwrap(), 0);
}

/// The archive of a capture that was ended early: without a gap, with the model and the report beside it.
fn assert_ended_in_order(bench: &Bench) {
    let entries = std::fs::read_dir(bench.path("out")).unwrap().flatten().map(|entry| entry.path());
    let archive = entries.into_iter().find(|path| path.extension().is_some_and(|found| found == "mcap")).unwrap();
    let capture = Capture::load(&archive).unwrap();
    assert!(capture.gaps.is_empty());
    let ticks = capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0];
    assert_eq!(ticks, capture.tick.last().unwrap() + 1);
    assert!((10_000..400_000).contains(&ticks), "{ticks} ticks");
    for result in ["toml", "html", "json"] {
        assert!(archive.with_extension(result).exists(), "no {result} was written");
    }
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_hangup_ends_a_capture_in_order_though_nobody_reads_its_output_any_more() {
    let bench = Bench::new().unwrap();
    let mut child = bench.start(&["capture", "--duration-s", "60", "--no-viewer", "--out", "out"]).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(3));
    drop((child.stdout.take(), child.stderr.take()));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGHUP).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert_ended_in_order(&bench);
}

#[test]
fn a_capture_that_was_started_to_outlive_its_terminal_goes_on_to_its_end() {
    let bench = Bench::new().unwrap();
    let plain = bench.command(&["capture", "--duration-s", "5", "--no-viewer", "--out", "out"]).unwrap();
    let mut child = Command::new("nohup")
        .arg(plain.get_program())
        .args(plain.get_args())
        .env(shared_types::rig::RUNTIME_DIR_VARIABLE, bench.path("rig"))
        .current_dir(plain.get_current_dir().unwrap())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(2));
    kill(Pid::from_raw(i32::try_from(child.id()).unwrap()), Signal::SIGHUP).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert_eq!(capture.tick.last(), Some(&49_999));
}

#[test]
fn a_terminal_that_is_closed_ends_a_capture_in_order() {
    let bench = Bench::new().unwrap();
    let capture = bench.command(&["capture", "--duration-s", "60", "--no-viewer", "--out", "out"]).unwrap();
    let words: Vec<String> = std::iter::once(capture.get_program())
        .chain(capture.get_args())
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    // A terminal of its own, whose panel the capture draws; the kernel hangs it up when `script` dies.
    let mut terminal = Command::new("script")
        .args(["--quiet", "--command", &format!("exec {}", words.join(" ")), "/dev/null"])
        .env(shared_types::rig::RUNTIME_DIR_VARIABLE, bench.path("rig"))
        .env("TERM", "xterm")
        .current_dir(capture.get_current_dir().unwrap())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(3));
    terminal.kill().unwrap();
    terminal.wait().unwrap();
    while !bench.processes("haptic-camera").is_empty() {
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(bench.end_orphans(), 0);
    assert_ended_in_order(&bench);
}
