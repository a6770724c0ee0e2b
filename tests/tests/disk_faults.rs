//! Disks and folders that fail under a capture: what is kept, and that the loop does not notice.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::time::Duration;

use archive::Capture;
use tests::{Bench, printed};

const SECONDS: u64 = 5;

/// A disk of so many kilobytes, for as long as it lives.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn mount(place: &Path, kilobytes: u32) -> Option<Self> {
        std::fs::create_dir(place).unwrap();
        let size = format!("size={kilobytes}k");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(place).output();
        if mounted.is_ok_and(|output| output.status.success()) {
            return Some(Self(place.to_owned()));
        }
        eprintln!("SKIPPED: no permission to mount a small disk");
        None
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // What stays mounted goes with the machine; there is nothing better to do.
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}

/// A capture into `out`, with `other` as the temporary directory.
fn start(bench: &Bench) -> Child {
    let duration = SECONDS.to_string();
    let mut command = bench.command(&["capture", "--duration-s", &duration, "--no-viewer", "--out", "out"]).unwrap();
    command.env("TMPDIR", bench.path("other")).spawn().unwrap()
}

/// The status, and that the failure was told; what the capture said.
fn ended(child: Child, status: i32, said: &[&str]) -> Output {
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{}", printed(&output));
    for words in said {
        assert!(printed(&output).contains(words), "'{words}' is missing in {}", printed(&output));
    }
    output
}

/// Every sample of the run is in its only archive in `other`; the loop had every tick.
fn assert_whole_in_other(bench: &Bench) {
    let capture = Capture::load(&bench.only_archive("other").unwrap()).unwrap();
    assert_eq!(capture.gaps, []);
    assert!(capture.seq.iter().enumerate().all(|(index, &seq)| seq == index as u64), "no sample is missing");
    assert_eq!(capture.len() as u64 + capture.ticks_without_sample() + capture.tick[0], SECONDS * 10_000);
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_capture_on_a_disk_that_fills_up_is_whole_in_the_temporary_directory() {
    let bench = Bench::new().unwrap();
    let Some(_disk) = SmallDisk::mount(&bench.path("out"), 2048) else { return };
    std::fs::create_dir(bench.path("other")).unwrap();
    ended(start(&bench), 0, &["No space left", "recording goes on in"]);
    assert_whole_in_other(&bench);
}

#[test]
fn a_capture_whose_folder_is_removed_is_whole_in_the_temporary_directory() {
    let bench = Bench::new().unwrap();
    std::fs::create_dir(bench.path("other")).unwrap();
    let child = start(&bench);
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(2));
    std::fs::remove_dir_all(bench.path("out")).unwrap();
    ended(child, 0, &["was removed or moved while it was written", "recording goes on in"]);
    assert_whole_in_other(&bench);
}

#[test]
fn a_capture_with_no_room_anywhere_keeps_what_fitted_and_ends_with_status_3() {
    let bench = Bench::new().unwrap();
    let Some(_out) = SmallDisk::mount(&bench.path("out"), 1536) else { return };
    let Some(_other) = SmallDisk::mount(&bench.path("other"), 1536) else { return };
    let output = ended(start(&bench), 3, &["no other place is left", "haptic-camera recover"]);
    assert!(printed(&output).contains("samples  "), "the run itself went to its end: {}", printed(&output));
    // As the message says, once there is room: parts in both places are one archive's.
    let parts: Vec<PathBuf> = ["out", "other"]
        .iter()
        .flat_map(|folder| std::fs::read_dir(bench.path(folder)).unwrap().flatten())
        .map(|entry| entry.path())
        .collect();
    let merged = archive::merge(&parts, &bench.path("merged.mcap"), None).unwrap();
    assert!(merged.ledger.admitted() > 10_000, "{parts:?}: {merged:?}");
    assert_eq!(merged.ledger.missing(), 0, "what is there is without a gap");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_capture_into_a_read_only_folder_goes_to_the_temporary_directory() {
    let bench = Bench::new().unwrap();
    let Some(disk) = SmallDisk::mount(&bench.path("out"), 1536) else { return };
    std::fs::create_dir(bench.path("other")).unwrap();
    assert!(Command::new("mount").args(["-o", "remount,ro"]).arg(&disk.0).status().unwrap().success());
    ended(start(&bench), 0, &["Read-only file system", "recording to"]);
    assert_whole_in_other(&bench);
}
