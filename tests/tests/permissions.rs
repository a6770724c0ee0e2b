//! What others on the machine may do: nothing.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use archive::Capture;
use tests::live_view::{LiveView, listening_addresses};
use tests::other_user::{as_nobody, there_is_nobody};
use tests::{Bench, printed};

const CAPTURE: [&str; 6] = ["capture", "--duration-s", "4", "--no-viewer", "--out", "out"];

/// A folder and everything in it.
fn with_everything_in(folder: &Path) -> Vec<PathBuf> {
    let mut found = vec![folder.to_owned()];
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            found.extend(with_everything_in(&entry.path()));
        } else {
            found.push(entry.path());
        }
    }
    found
}

fn assert_closed_to_others(paths: &[PathBuf]) {
    for path in paths {
        // What is gone by now nobody can open.
        let mode = path.metadata().map_or(0, |found| found.mode());
        assert_eq!(mode & 0o077, 0, "{} has the mode {mode:o}", path.display());
    }
}

#[test]
fn shared_memory_runtime_directory_and_archives_are_open_to_the_user_alone() {
    let bench = Bench::new().unwrap();
    let child = bench.start(&CAPTURE).unwrap();
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let segments = bench.shared_memory();
    assert!(segments.len() > 10, "the rig is in shared memory: {segments:?}");
    // Whoever may not enter the folder in shared memory, or the runtime directory, reaches nothing in it.
    assert!(segments[1..].iter().all(|path| path.starts_with(&segments[0])), "{segments:?}");
    assert_closed_to_others(&[segments[0].clone(), bench.path("rig")]);
    assert_closed_to_others(&with_everything_in(&bench.path("out")));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let files = with_everything_in(&bench.path("out"));
    assert!(files.len() >= 4, "the folder, archive, model and report: {files:?}");
    assert_closed_to_others(&files);
}

#[test]
fn another_user_can_neither_read_the_rig_nor_command_nor_stop_it() {
    if there_is_nobody() {
        return;
    }
    let bench = Bench::new().unwrap();
    let child = bench.start(&CAPTURE).unwrap();
    let recorder = bench.wait_for_process("recorder").unwrap();
    let control_loop = bench.wait_for_process("rt-loop").unwrap();
    std::thread::sleep(std::time::Duration::from_secs(1));
    let segments = bench.shared_memory();
    assert!(segments.len() > 10);
    for segment in &segments {
        for access in ["if", "of"] {
            let place = format!("{access}={}", segment.display());
            let output = as_nobody(Path::new("dd"), &[&place, "count=1", "conv=notrunc"]).output().unwrap();
            assert!(!output.status.success() || !segment.exists(), "nobody could open {}", segment.display());
        }
    }
    for place in ["rig", "out"] {
        let output = as_nobody(Path::new("ls"), &[&bench.path(place).to_string_lossy()]).output().unwrap();
        assert!(!output.status.success(), "nobody could list {place}");
    }
    for process in [recorder, control_loop] {
        for signal in ["-TERM", "-KILL", "-STOP"] {
            let output = as_nobody(Path::new("kill"), &[signal, &process.to_string()]).output().unwrap();
            assert!(!output.status.success(), "nobody could send {signal}");
        }
    }
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    let capture = Capture::load(&bench.only_archive("out").unwrap()).unwrap();
    assert!(capture.gaps.is_empty());
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], 40_000);
}

#[test]
fn another_user_cannot_lock_the_page_out() {
    if there_is_nobody() {
        return;
    }
    let bench = Bench::new().unwrap();
    let child = bench.start(&["capture", "--duration-s", "10", "--out", "out"]).unwrap();
    let view = LiveView::of_rig(&bench.path("rig")).unwrap();
    view.wait_for(|status| status["time_s"].as_f64() > Some(0.5)).unwrap();
    let addresses = listening_addresses(bench.wait_for_process("rerun-viewer").unwrap()).unwrap();
    let (_, port) = addresses[0].split_once(':').unwrap();
    let port = u16::from_str_radix(port, 16).unwrap();
    let hold =
        format!("for i in $(seq 200); do exec {{fd}}<>/dev/tcp/127.0.0.1/{port} || break; echo $i; done; sleep 4");
    let flood = as_nobody(Path::new("bash"), &["-c", &hold]).stdout(std::process::Stdio::piped()).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    let ask = format!(
        "exec 3<>/dev/tcp/127.0.0.1/{port}; printf 'GET /status HTTP/1.1\\r\\nHost: 127.0.0.1:{port}\\r\\nConnection: close\\r\\n\\r\\n' >&3; timeout 5 cat <&3"
    );
    let answer = Command::new("bash").args(["-c", &ask]).output().unwrap().stdout;
    let opened = flood.wait_with_output().unwrap().stdout;
    assert!(opened.ends_with(b"\n200\n"), "200 connections: {}", String::from_utf8_lossy(&opened));
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
    assert!(answer.starts_with(b"HTTP/1.1 200"), "the page answers its own user: {}", String::from_utf8_lossy(&answer));
}

#[test]
fn another_user_is_shown_nothing_by_the_live_view() {
    if there_is_nobody() {
        return;
    }
    let bench = Bench::new().unwrap();
    let child = bench.start(&["capture", "--duration-s", "6", "--out", "out"]).unwrap();
    let view = LiveView::of_rig(&bench.path("rig")).unwrap();
    view.wait_for(|status| status["time_s"].as_f64() > Some(0.5)).unwrap();
    let addresses = listening_addresses(bench.wait_for_process("rerun-viewer").unwrap()).unwrap();
    assert_eq!(addresses.len(), 1, "the page and nothing else: {addresses:?}");
    let (_, port) = addresses[0].split_once(':').unwrap();
    let port = u16::from_str_radix(port, 16).unwrap();
    let question = |path: &str, host: &str| {
        let words = format!("GET /{path} HTTP/1.1\\r\\nHost: {host}\\r\\nConnection: close\\r\\n\\r\\n");
        format!("exec 3<>/dev/tcp/127.0.0.1/{port}; printf '{words}' >&3; cat <&3")
    };
    for path in ["status", "drawn", ""] {
        let ask = question(path, &format!("127.0.0.1:{port}"));
        let ours = Command::new("bash").args(["-c", &ask]).output().unwrap().stdout;
        assert!(ours.starts_with(b"HTTP/1.1 200"), "{}", String::from_utf8_lossy(&ours));
        let theirs = as_nobody(Path::new("bash"), &["-c", &ask]).output().unwrap().stdout;
        assert!(theirs.starts_with(b"HTTP/1.1 403"), "{}", String::from_utf8_lossy(&theirs));
        assert!(theirs.len() < 1000, "{} bytes for another user", theirs.len());
        // A page of somebody whose name means this machine, in our own browser.
        let by_name = Command::new("bash").args(["-c", &question(path, "knobs.example:80")]).output().unwrap().stdout;
        assert!(by_name.starts_with(b"HTTP/1.1 403"), "{}", String::from_utf8_lossy(&by_name));
    }
    assert_closed_to_others(&[bench.path("rig")]);
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", printed(&output));
}
