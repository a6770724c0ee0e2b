//! Disks and folders that fail under a capture: what is kept, and that the loop does not notice.
#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "a test may stop at a failure; a skipped one says so")]

use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output};
use std::time::Duration;

use archive::Capture;
use tests::small_disk::SmallDisk;
use tests::{Bench, printed};

const SECONDS: u64 = 5;

/// A capture into `out`, with `other` as the temporary directory.
fn start(bench: &Bench) -> Child {
    let duration = SECONDS.to_string();
    let mut command = bench.command(&["capture", "--duration-s", &duration, "--no-viewer", "--out", "out"]).unwrap();
    command.env("TMPDIR", bench.path("other")).spawn().unwrap()
}

/// Asserts the status and that the failure was reported; returns what the capture printed.
fn ended(child: Child, status: i32, said: &[&str]) -> Output {
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(status), "{}", printed(&output));
    for words in said {
        assert!(printed(&output).contains(words), "'{words}' is missing in {}", printed(&output));
    }
    output
}

/// The run's own folder in the temporary directory.
fn fallback(bench: &Bench) -> PathBuf {
    let folders: Vec<PathBuf> =
        std::fs::read_dir(bench.path("other")).unwrap().flatten().map(|entry| entry.path()).collect();
    assert_eq!(folders.len(), 1, "one run, one folder: {folders:?}");
    assert_eq!(folders[0].metadata().unwrap().mode() & 0o777, 0o700, "closed to others");
    folders[0].clone()
}

fn assert_whole_in_other(bench: &Bench) {
    let folder = fallback(bench);
    let archive = bench.only_archive(folder.to_str().unwrap()).unwrap();
    assert_whole(bench, &Capture::load(&archive).unwrap());
}

/// Every sample of the run is there, and the loop had every tick.
fn assert_whole(bench: &Bench, capture: &Capture) {
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
    ended(start(&bench), 0, &["No space left", "recording continues in"]);
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
    ended(child, 0, &["was removed or moved while it was written", "recording continues in"]);
    assert_whole_in_other(&bench);
}

#[test]
fn a_capture_with_no_room_anywhere_keeps_what_fitted_and_ends_with_status_3() {
    let bench = Bench::new().unwrap();
    let Some(_out) = SmallDisk::mount(&bench.path("out"), 1536) else { return };
    let Some(_other) = SmallDisk::mount(&bench.path("other"), 1536) else { return };
    let output = ended(start(&bench), 3, &["no other folder is left", "haptic-camera recover"]);
    assert!(printed(&output).contains("samples  "), "the run itself went to its end: {}", printed(&output));
    // As the message says, once there is room: parts in both places are one archive's.
    let parts: Vec<PathBuf> = [bench.path("out"), fallback(&bench)]
        .iter()
        .flat_map(|folder| std::fs::read_dir(folder).unwrap().flatten())
        .map(|entry| entry.path())
        .collect();
    let merged = archive::merge(&parts, &bench.path("merged.mcap"), None).unwrap();
    assert!(merged.ledger.admitted() > 10_000, "{parts:?}: {merged:?}");
    assert_eq!(merged.ledger.missing(), 0, "what is there is without a gap");
    let (archive, _number) = parts[0].to_str().unwrap().rsplit_once(".part-").unwrap();
    let mut recover = bench.command(&["recover", archive, "--out", "recovered.mcap"]).unwrap();
    let recovered = recover.env("TMPDIR", bench.path("other")).output().unwrap();
    assert_eq!(recovered.status.code(), Some(3), "{}", printed(&recovered));
    let kept = Capture::load(&bench.path("recovered.mcap")).unwrap().len() as u64;
    assert_eq!(kept, merged.ledger.admitted(), "the parts in both places were found");
    assert_eq!(bench.leftovers(), Vec::<String>::new());
}

#[test]
fn a_capture_into_a_read_only_folder_goes_to_the_temporary_directory() {
    let bench = Bench::new().unwrap();
    let Some(disk) = SmallDisk::mount(&bench.path("out"), 1536) else { return };
    std::fs::create_dir(bench.path("other")).unwrap();
    disk.remount("ro");
    ended(start(&bench), 0, &["Read-only file system", "recording to"]);
    assert_whole_in_other(&bench);
}

/// A disk whose writers wait while it is frozen, for as long as it lives.
struct StallingDisk(PathBuf);

impl StallingDisk {
    fn mount(place: &Path) -> Option<Self> {
        std::fs::create_dir(place).unwrap();
        let image = place.with_extension("img");
        std::fs::File::create(&image).unwrap().set_len(64 * 1024 * 1024).unwrap();
        let steps = [
            ["mkfs.ext4", "-q", "-F"].map(str::to_owned).to_vec(),
            ["mount", "-o", "loop"].map(str::to_owned).to_vec(),
        ];
        for (mut step, further) in steps.into_iter().zip([vec![&image], vec![&image, &place.to_path_buf()]]) {
            step.extend(further.iter().map(|path| path.to_string_lossy().into_owned()));
            let done = Command::new(&step[0]).args(&step[1..]).output();
            if !done.is_ok_and(|output| output.status.success()) {
                eprintln!("SKIPPED: no permission to mount a disk that can be frozen ({})", step[0]);
                return None;
            }
        }
        Some(Self(place.to_owned()))
    }

    fn freeze(&self, how: &str) {
        assert!(Command::new("fsfreeze").arg(how).arg(&self.0).status().unwrap().success());
    }
}

impl Drop for StallingDisk {
    fn drop(&mut self) {
        // It is frozen only if the test failed meanwhile; what stays mounted goes with the machine.
        let _ = Command::new("fsfreeze").arg("--unfreeze").arg(&self.0).output();
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}

#[test]
fn a_disk_that_stalls_for_three_seconds_costs_no_sample() {
    let bench = Bench::new().unwrap();
    let Some(disk) = StallingDisk::mount(&bench.path("out")) else { return };
    std::fs::create_dir(bench.path("other")).unwrap();
    let child = start(&bench);
    bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(1));
    disk.freeze("--freeze");
    std::thread::sleep(Duration::from_secs(3));
    disk.freeze("--unfreeze");
    ended(child, 0, &[]);
    let captures: Vec<PathBuf> = std::fs::read_dir(&disk.0).unwrap().flatten().map(|entry| entry.path()).collect();
    let archive = captures.iter().find(|path| path.extension().is_some_and(|ending| ending == "mcap")).unwrap();
    assert_whole(&bench, &Capture::load(archive).unwrap());
}

/// Ends a capture whose recorder meets, from its third second on, this error of the system's at these calls.
///
/// The calls are made to fail by libfiu (`fiu-utils`), which stands between the programs and the C library.
fn capture_with_failing_calls(bench: &Bench, calls: &[&str], error: nix::errno::Errno, how: &str) -> Child {
    std::fs::create_dir(bench.path("other")).unwrap();
    let mut command =
        bench.command(&["capture", "--duration-s", &SECONDS.to_string(), "--no-viewer", "--out", "out"]).unwrap();
    let child = command
        .env("TMPDIR", bench.path("other"))
        .env("LD_PRELOAD", "/usr/lib/fiu/fiu_run_preload.so /usr/lib/fiu/fiu_posix_preload.so")
        .env("FIU_CTRL_FIFO", bench.path("control"))
        .spawn()
        .unwrap();
    let recorder = bench.wait_for_process("recorder").unwrap();
    std::thread::sleep(Duration::from_secs(2));
    for call in calls {
        let status = Command::new("fiu-ctrl")
            .arg("-f")
            .arg(bench.path("control"))
            .args(["-c", &format!("enable name={call},failinfo={}{how}", error as i32), &recorder.to_string()])
            .status();
        assert!(status.is_ok_and(|status| status.success()), "fiu-ctrl is missing: scripts/set-up tests installs it");
    }
    child
}

#[test]
fn what_a_disk_took_and_lost_is_written_again() {
    let bench = Bench::new().unwrap();
    let calls = ["posix/io/sync/fdatasync"];
    let child = capture_with_failing_calls(&bench, &calls, nix::errno::Errno::EIO, ",onetime");
    ended(child, 0, &["Input/output error", "recording continues in"]);
    // Whole in whatever parts: merged into the folder that was asked for.
    assert_whole(&bench, &Capture::load(&bench.only_archive("out").unwrap()).unwrap());
}

#[test]
fn a_disk_that_fails_at_the_very_end_costs_nothing() {
    let bench = Bench::new().unwrap();
    let calls = ["posix/io/sync/fsync"];
    let child = capture_with_failing_calls(&bench, &calls, nix::errno::Errno::EIO, ",onetime");
    ended(child, 0, &["Input/output error", "written again"]);
    assert_whole(&bench, &Capture::load(&bench.only_archive("out").unwrap()).unwrap());
}

#[test]
fn a_used_up_quota_is_a_full_disk() {
    let bench = Bench::new().unwrap();
    let calls = ["posix/io/rw/write"];
    let child = capture_with_failing_calls(&bench, &calls, nix::errno::Errno::EDQUOT, ",onetime");
    ended(child, 0, &["Disk quota exceeded", "recording continues in"]);
    assert_whole(&bench, &Capture::load(&bench.only_archive("out").unwrap()).unwrap());
}
