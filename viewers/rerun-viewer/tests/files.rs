//! The files that the program writes: whole or complained about, and for its user alone.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may stop at a failure, and says when it skips")]

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A folder with a short capture in it.
fn bench() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("capture.csv");
    let rows: String = (0..2_000)
        .map(|row| f64::from(row) / 1_000.0)
        .map(|t_s| format!("{t_s},{},{}\n", (3.0 * t_s).sin(), (3.0 * t_s).cos().signum()))
        .collect();
    std::fs::write(&capture, format!("t_s,angle_rad,torque_mnm\n{rows}")).unwrap();
    (folder, capture)
}

/// The program with a rig of its own and the umask that most systems have.
fn viewer(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new("bash");
    command.args(["-c", "umask 022; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rerun-viewer")]).args(arguments);
    command.env("HAPTIC_CAMERA_RUNTIME_DIR", folder.join("rig"));
    command
}

fn save(folder: &Path, capture: &Path, to: &str) -> Output {
    viewer(folder, &["--capture", capture.to_str().unwrap(), "--save", to]).output().unwrap()
}

/// Permissions of a file for group and others.
fn for_others(path: &Path) -> u32 {
    path.symlink_metadata().unwrap().permissions().mode() & 0o077
}

fn one_sentence(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr).trim().to_owned();
    assert_eq!(said.lines().count(), 1, "{said}");
    said
}

#[test]
fn a_recording_that_cannot_be_written_is_a_failure() {
    let (folder, capture) = bench();
    // Like /dev/full, in a folder where nothing else can come to harm.
    let full = folder.path().join("full");
    let made = Command::new("mknod").arg(&full).args(["c", "1", "7"]).output();
    if !made.is_ok_and(|made| made.status.success()) {
        println!("SKIPPED: a device that is always full cannot be made here");
        return;
    }
    let output = save(folder.path(), &capture, full.to_str().unwrap());
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(one_sentence(&output).contains("full cannot be written (No space left on device"), "{output:?}");
}

#[test]
fn a_recording_that_fills_its_disk_is_a_failure() {
    let (folder, capture) = bench();
    let disk = folder.path().join("disk");
    std::fs::create_dir(&disk).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=16k", "tmpfs"]).arg(&disk).output();
    if !mount.is_ok_and(|mount| mount.status.success()) {
        println!("SKIPPED: a small disk cannot be mounted here");
        return;
    }
    let output = save(folder.path(), &capture, disk.join("capture.rrd").to_str().unwrap());
    Command::new("umount").arg(&disk).status().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(one_sentence(&output).contains("No space left on device"), "{output:?}");
}

#[test]
fn a_recording_is_for_its_user_alone_and_replaces_only_its_like() {
    let (folder, capture) = bench();
    let [recording, earlier] = ["capture.rrd", "earlier.rrd"].map(|name| folder.path().join(name));
    for time in 0..2 {
        if time == 1 {
            // Shows whether the earlier one is written into.
            std::fs::write(&recording, b"RRF2, and no more").unwrap();
            std::fs::hard_link(&recording, &earlier).unwrap();
        }
        let output = save(folder.path(), &capture, recording.to_str().unwrap());
        assert!(output.status.success(), "{output:?}");
        assert!(recording.metadata().unwrap().len() > 1_000);
        assert_eq!(for_others(&recording), 0);
        // As one that was written before it was made private.
        std::fs::set_permissions(&recording, std::fs::Permissions::from_mode(0o644)).unwrap();
    }
    assert_eq!(std::fs::read(&earlier).unwrap(), b"RRF2, and no more");
    let left_over = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.unwrap().file_name().to_string_lossy().ends_with(".incomplete")
    };
    assert!(!std::fs::read_dir(folder.path()).unwrap().any(left_over));
    let notes = folder.path().join("notes.txt");
    std::fs::write(&notes, "not a recording").unwrap();
    let output = save(folder.path(), &capture, notes.to_str().unwrap());
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(one_sentence(&output).contains("is no rerun file"), "{output:?}");
    assert_eq!(std::fs::read_to_string(&notes).unwrap(), "not a recording");
}

/// A child that is ended with the test.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn what_a_view_leaves_in_the_rigs_folder_is_for_its_user_alone() {
    let (folder, _) = bench();
    let running = Running(
        viewer(folder.path(), &["--web-port", "39090"]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap(),
    );
    let rig = folder.path().join("rig");
    let deadline = Instant::now() + Duration::from_secs(60);
    while !rig.join("live-view-port.json").exists() {
        assert!(Instant::now() < deadline, "no port is noted");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(for_others(&rig), 0);
    // The folders within are iceoryx2's.
    for path in rig.read_dir().unwrap().map(|entry| entry.unwrap().path()).filter(|path| !path.is_dir()) {
        assert_eq!(for_others(&path), 0, "{}", path.display());
    }
    drop(running);
}
