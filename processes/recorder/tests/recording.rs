//! The recorder as a process: fed through shared memory, killed, restarted, stopped.

#![allow(clippy::unwrap_used, clippy::print_stderr, reason = "tests; a skipped one says so")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use archive::Capture;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections as _;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use shared_types::services::{self, FIT_UPDATES, LOOP_STATUS, MessagePublisher, RigNode, SamplePublisher};
use shared_types::{
    BlockHeader, ClockMapping, FitUpdate, LoopStatus, PrivateIpc, RunDescription, Sample, clean_up, rig,
};
use tempfile::TempDir;

const RUN_ID: u64 = 0xfeed;
const RATE_HZ: f64 = 10_000.0;

/// The runtime directory is a variable of the whole process: one rig at a time is set up.
static ENVIRONMENT: Mutex<()> = Mutex::new(());

/// Stands in for the control loop: publishes samples as it does, in this test's own rig.
struct Rig {
    samples: SamplePublisher,
    status: MessagePublisher<LoopStatus>,
    fits: MessagePublisher<FitUpdate>,
    description: Publisher<PrivateIpc, [u8], ()>,
    published: u64,
    process_id: u32,
    _node: RigNode,
    _shared_memory: SharedMemory,
    directory: TempDir,
}

/// What iceoryx2 leaves of the rig of this runtime directory when its last process has gone: removed with the test.
struct SharedMemory(PathBuf);

impl Drop for SharedMemory {
    fn drop(&mut self) {
        if let Some(folder) = clean_up::files_in_shared_memory(&self.0).first() {
            // Another process of the rig may have removed it just now.
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

/// A process that does not outlive its test.
struct Process(Child);

impl Process {
    fn start(command: &mut Command) -> Self {
        Self(command.spawn().unwrap())
    }

    fn kill(&mut self) {
        self.0.kill().unwrap();
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // It has ended already unless the test failed.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Rig {
    fn new() -> Self {
        let directory = tempfile::tempdir().unwrap();
        let _one_at_a_time = ENVIRONMENT.lock().unwrap();
        // SAFETY: the lock keeps other tests from the environment, and nothing else here reads it.
        #[allow(unsafe_code, reason = "each test has a rig of its own")]
        unsafe {
            std::env::set_var(rig::RUNTIME_DIR_VARIABLE, directory.path().join("rig"));
        }
        let node = services::attach("test").unwrap();
        let mut rig = Self {
            samples: services::sample_publisher(&node).unwrap(),
            status: LOOP_STATUS.publisher(&node).unwrap(),
            fits: FIT_UPDATES.publisher(&node).unwrap(),
            description: services::description_publisher(&node).unwrap(),
            published: 0,
            process_id: std::process::id(),
            _node: node,
            _shared_memory: SharedMemory(rig::runtime_dir()),
            directory,
        };
        std::fs::create_dir(rig.elsewhere()).unwrap();
        rig.describe();
        rig
    }

    fn describe(&mut self) {
        let json = serde_json::to_vec(&description(RUN_ID)).unwrap();
        self.description.loan_slice_uninit(json.len()).unwrap().write_from_slice(&json).send().unwrap();
    }

    fn out(&self) -> PathBuf {
        self.directory.path().join("run.mcap")
    }

    /// The temporary directory as the recorder sees it.
    fn elsewhere(&self) -> PathBuf {
        self.directory.path().join("elsewhere")
    }

    /// Where it goes on when the folder that was asked for fails.
    fn fallback(&self) -> PathBuf {
        let run = archive::parts::fallback_dir(RUN_ID);
        self.elsewhere().join(run.file_name().unwrap())
    }

    fn start_recorder(&self, restarts: u32) -> Process {
        self.start_recorder_to(&self.out(), restarts)
    }

    fn start_recorder_to(&self, out: &Path, restarts: u32) -> Process {
        Process::start(
            Command::new(env!("CARGO_BIN_EXE_recorder"))
                .arg("--out")
                .arg(out)
                .args(["--restarts", &restarts.to_string()])
                .env(rig::RUNTIME_DIR_VARIABLE, self.directory.path().join("rig"))
                .env("TMPDIR", self.elsewhere()),
        )
    }

    /// Publishes so many blocks of ten samples, one each millisecond, with estimates in between.
    fn publish_blocks(&mut self, blocks: usize) {
        for _ in 0..blocks {
            self.publish_block_of(RUN_ID);
            if self.published.is_multiple_of(500) {
                let update = FitUpdate {
                    run_id: RUN_ID,
                    latest_tick: self.published,
                    monotonic_time_ns: rig::monotonic_time_ns(),
                    ..FitUpdate::default()
                };
                self.fits.send_copy(update).unwrap();
                self.publish_status(false);
                self.description.update_connections().unwrap();
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn publish_block_of(&mut self, run_id: u64) {
        let block: Vec<Sample> = (0..10).map(|offset| sample(self.published + offset)).collect();
        let mut loan = self.samples.loan_slice_uninit(block.len()).unwrap();
        *loan.user_header_mut() = BlockHeader { run_id };
        loan.write_from_slice(&block).send().unwrap();
        self.published += 10;
    }

    fn publish_status(&self, finished: bool) {
        let status = LoopStatus {
            run_id: RUN_ID,
            monotonic_time_ns: rig::monotonic_time_ns(),
            published_samples: self.published,
            finished: u32::from(finished),
            process_id: self.process_id,
            ..LoopStatus::default()
        };
        self.status.send_copy(status).unwrap();
    }

    /// Ends the run as the control loop does: says so again and again, and keeps history reachable.
    fn finish(&self, recorder: &mut Process) -> i32 {
        self.wait(recorder, || {
            self.publish_status(true);
            self.samples.update_connections().unwrap();
            self.description.update_connections().unwrap();
        })
    }

    /// Waits for the recorder to end; its exit status.
    fn wait(&self, recorder: &mut Process, meanwhile: impl Fn()) -> i32 {
        let started = Instant::now();
        loop {
            if let Some(status) = recorder.0.try_wait().unwrap() {
                return status.code().unwrap_or(-1);
            }
            assert!(started.elapsed() < Duration::from_secs(60), "the recorder does not end");
            meanwhile();
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn wait_for(&mut self, what: &str, mut there: impl FnMut(&Path) -> bool) {
        let started = Instant::now();
        while !there(self.directory.path()) {
            assert!(started.elapsed() < Duration::from_secs(60), "{what} does not come");
            self.publish_blocks(1);
        }
    }

    /// Asserts that the archive holds every published sample, bit for bit.
    fn assert_complete(&self, archive: &Path) {
        let capture = Capture::load(archive).unwrap();
        assert_eq!(capture.len() as u64, self.published);
        assert_eq!(capture.gaps, []);
        for (row, (&seq, &torque)) in capture.seq.iter().zip(&capture.torque_mnm).enumerate() {
            assert_eq!(seq, row as u64);
            assert_eq!(torque.to_bits(), sample(seq).torque_mnm.to_bits());
        }
    }
}

fn sample(seq: u64) -> Sample {
    Sample {
        seq,
        tick: seq,
        monotonic_time_ns: rig::monotonic_time_ns(),
        angle_rad: (seq as f64 * 1e-3).sin(),
        torque_mnm: (seq as f64 * 0.7).cos() * 10.0,
        ..Sample::default()
    }
}

/// Archives and parts in a directory.
fn files_in(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.contains("mcap"))
        .collect();
    names.sort();
    names
}

fn send(signal: Signal, process: &Process) {
    kill(Pid::from_raw(i32::try_from(process.0.id()).unwrap()), signal).unwrap();
}

#[test]
fn a_run_is_recorded_whole() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(1500);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.out());
}

#[test]
fn an_archive_in_the_temporary_directory_is_like_any_other() {
    let mut rig = Rig::new();
    let out = rig.elsewhere().join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&rig.elsewhere()), ["run.mcap"]);
    rig.assert_complete(&out);
}

#[test]
fn a_killed_recorder_resumes_without_a_gap() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    for restart in 1..=3 {
        let part = format!("run.mcap.part-{:03}", restart - 1);
        rig.wait_for(&part, |path| path.join(&part).exists());
        rig.publish_blocks(900);
        recorder.kill();
        rig.publish_blocks(100);
        recorder = rig.start_recorder(restart);
    }
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.out());
}

#[test]
fn a_recorder_that_comes_after_the_run_records_what_history_holds() {
    let mut rig = Rig::new();
    rig.publish_blocks(600);
    let mut recorder = rig.start_recorder(0);
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn samples_that_never_come_are_reported_by_status_3_and_a_gap() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(200);
    let first_missing_seq = rig.published;
    rig.published += 70;
    rig.publish_blocks(200);
    let next = rig.published;
    rig.published += 5;
    assert_eq!(rig.finish(&mut recorder), 3);
    let gaps = Capture::load(&rig.out()).unwrap().gaps;
    let bounds: Vec<(u64, u64)> = gaps.iter().map(|gap| (gap.first_missing_seq, gap.last_missing_seq)).collect();
    assert_eq!(bounds, [(first_missing_seq, first_missing_seq + 69), (next, next + 4)]);
}

#[test]
fn a_recorder_that_is_reported_to_stop_ends_its_archive_and_ignores_ctrl_c() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(300);
    send(Signal::SIGINT, &recorder);
    rig.publish_blocks(300);
    assert!(recorder.0.try_wait().unwrap().is_none(), "an interrupt from the keyboard is the supervisor's to handle");
    send(Signal::SIGTERM, &recorder);
    assert_eq!(rig.wait(&mut recorder, || {}), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn a_recorder_whose_source_dies_ends_its_archive() {
    let mut rig = Rig::new();
    let mut source = Process::start(Command::new("sleep").arg("1000"));
    rig.process_id = source.0.id();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(400);
    rig.publish_status(false);
    source.kill();
    // Killed and not reaped: a dead process that still has an entry.
    assert_eq!(rig.wait(&mut recorder, || {}), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn blocks_of_another_run_stay_out_of_the_archive() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(100);
    let published = rig.published;
    rig.publish_block_of(RUN_ID + 1);
    rig.published = published;
    rig.publish_blocks(100);
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.out());
}

#[test]
fn an_archive_of_another_run_is_never_overwritten() {
    let mut rig = Rig::new();
    let other = archive_of_run(1);
    std::fs::write(rig.out(), &other).unwrap();
    rig.publish_blocks(10);
    let mut recorder = rig.start_recorder(0);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(std::fs::read(rig.out()).unwrap(), other);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn a_recorder_started_again_after_its_archive_was_ended_loses_nothing_of_it() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    // Longer than history reaches back.
    rig.publish_blocks(4500);
    assert_eq!(rig.finish(&mut recorder), 0);
    let mut again = rig.start_recorder(1);
    assert_eq!(rig.finish(&mut again), 0);
    assert_eq!(files_in(rig.directory.path()), ["run.mcap"]);
    rig.assert_complete(&rig.out());
}

#[test]
fn a_place_that_cannot_be_written_to_sends_the_recording_to_the_temporary_directory() {
    let mut rig = Rig::new();
    let mut recorder = rig.start_recorder_to(Path::new("/proc/no/such/place/run.mcap"), 0);
    let part = rig.fallback().join("run.mcap.part-000");
    rig.wait_for("the part elsewhere", |_| part.exists());
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&rig.fallback()), ["run.mcap"], "the archive is where there is room");
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

/// A disk of so many kilobytes, for as long as it lives.
struct SmallDisk(PathBuf);

impl SmallDisk {
    fn mount(place: &Path, kilobytes: u32) -> Option<Self> {
        if !place.exists() {
            std::fs::create_dir(place).unwrap();
        }
        let size = format!("size={kilobytes}k");
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", &size, "tmpfs"]).arg(place).output();
        if mounted.is_ok_and(|output| output.status.success()) {
            return Some(Self(place.to_owned()));
        }
        eprintln!("SKIPPED: no permission to mount a small disk");
        None
    }

    fn remount(&self, options: &str) {
        let options = format!("remount,{options}");
        assert!(Command::new("mount").args(["-o", &options]).arg(&self.0).status().unwrap().success());
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        // What stays mounted goes with the machine; there is nothing better to do.
        let _ = Command::new("umount").arg("--lazy").arg(&self.0).status();
    }
}

#[test]
fn a_folder_that_is_removed_during_the_run_costs_no_sample() {
    let mut rig = Rig::new();
    let folder = rig.directory.path().join("captures");
    let mut recorder = rig.start_recorder_to(&folder.join("run.mcap"), 0);
    rig.wait_for("the first part", |path| path.join("captures/run.mcap.part-000").exists());
    rig.publish_blocks(1200);
    std::fs::remove_dir_all(&folder).unwrap();
    rig.publish_blocks(1200);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&rig.fallback()), ["run.mcap"], "what was removed was saved from the open file");
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn a_disk_that_becomes_read_only_costs_no_sample() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 65_536) else { return };
    let out = disk.0.join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.wait_for("the first part", |path| path.join("disk/run.mcap.part-000").exists());
    rig.publish_blocks(1000);
    // The system permits it only while no file is open for writing, so between two lives of the recorder.
    recorder.kill();
    recorder.0.wait().unwrap();
    disk.remount("ro");
    let mut recorder = rig.start_recorder_to(&out, 1);
    rig.publish_blocks(1000);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&disk.0), ["run.mcap.part-000"], "what cannot be removed stays");
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn two_full_disks_cost_no_sample_when_room_is_made_in_time() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 512) else { return };
    let Some(other) = SmallDisk::mount(&rig.elsewhere(), 512) else { return };
    let mut recorder = rig.start_recorder_to(&disk.0.join("run.mcap"), 0);
    rig.publish_blocks(4000);
    other.remount("size=64m");
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn two_full_disks_leave_what_fitted_readable_and_the_loss_is_reported() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 512) else { return };
    let Some(_other) = SmallDisk::mount(&rig.elsewhere(), 512) else { return };
    let out = disk.0.join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.publish_blocks(4000);
    assert_eq!(rig.finish(&mut recorder), 3);
    let mut parts = Vec::new();
    for folder in [&disk.0, &rig.fallback()] {
        parts.extend(files_in(folder).into_iter().map(|name| folder.join(name)));
    }
    let merged = rig.directory.path().join("merged.mcap");
    let summary = archive::merge(&parts, &merged, Some(rig.published)).unwrap();
    assert!(summary.ledger.admitted() > 1000, "{parts:?} hold {} samples", summary.ledger.admitted());
    assert_eq!(summary.ledger.admitted() + summary.ledger.missing(), rig.published);
    let capture = Capture::load(&merged).unwrap();
    for (seq, torque) in capture.seq.iter().zip(&capture.torque_mnm) {
        assert_eq!(torque.to_bits(), sample(*seq).torque_mnm.to_bits());
    }
}

#[test]
fn a_disk_that_fills_up_costs_no_sample() {
    let mut rig = Rig::new();
    let Some(disk) = SmallDisk::mount(&rig.directory.path().join("disk"), 1024) else { return };
    let out = disk.0.join("run.mcap");
    let mut recorder = rig.start_recorder_to(&out, 0);
    rig.publish_blocks(3000);
    assert_eq!(rig.finish(&mut recorder), 0);
    assert_eq!(files_in(&disk.0), [""; 0], "the parts were merged elsewhere");
    assert_eq!(files_in(&rig.fallback()), ["run.mcap"]);
    rig.assert_complete(&rig.fallback().join("run.mcap"));
}

#[test]
fn what_the_recorder_did_not_make_is_never_part_of_its_run() {
    let mut rig = Rig::new();
    let place = rig.directory.path().to_owned();
    // Samples of nobody's run under the name of the next part, a pipe that nobody writes to, a folder, a link.
    let mut stranger = archive_with_samples(RUN_ID + 1);
    let name = stranger.windows(8).position(|bytes| bytes == b"run.json").unwrap();
    stranger[name] = b'X';
    std::fs::write(place.join("run.mcap.part-001"), &stranger).unwrap();
    assert!(Command::new("mkfifo").arg(place.join("run.mcap.part-002")).status().unwrap().success());
    std::fs::create_dir(place.join("run.mcap.part-003")).unwrap();
    std::fs::write(place.join("theirs"), archive_with_samples(RUN_ID)).unwrap();
    std::os::unix::fs::symlink("theirs", place.join("run.mcap.part-004")).unwrap();
    let mut recorder = rig.start_recorder(0);
    rig.wait_for("the first part", |path| path.join("run.mcap.part-000").exists());
    rig.publish_blocks(300);
    recorder.kill();
    let mut recorder = rig.start_recorder(1);
    rig.publish_blocks(300);
    assert_eq!(rig.finish(&mut recorder), 0);
    rig.assert_complete(&rig.out());
    let left: Vec<String> = (1..=4).map(|number| format!("run.mcap.part-00{number}")).collect();
    assert_eq!(files_in(&place), [&["run.mcap".to_owned()][..], &left].concat(), "what is not its own stays");
    assert_eq!(std::fs::read(place.join("run.mcap.part-001")).unwrap(), stranger);
}

/// An archive of a run with this identity and samples that the rig never published.
fn archive_with_samples(run_id: u64) -> Vec<u8> {
    let mut writer = archive::CaptureWriter::new(std::io::Cursor::new(Vec::new()), &description(run_id)).unwrap();
    for seq in 0..100_000 {
        writer.sample(&Sample { torque_mnm: 1e6, ..sample(seq) }).unwrap();
    }
    writer.finish().unwrap().1.into_inner()
}

/// An archive of a run with this identity, without samples.
fn archive_of_run(run_id: u64) -> Vec<u8> {
    let writer = archive::CaptureWriter::new(std::io::Cursor::new(Vec::new()), &description(run_id)).unwrap();
    writer.finish().unwrap().1.into_inner()
}

fn description(run_id: u64) -> RunDescription {
    RunDescription {
        run_id,
        software_version: "test".to_owned(),
        apparatus: "none".to_owned(),
        knob: "none".to_owned(),
        rate_hz: RATE_HZ,
        clock: ClockMapping {
            monotonic_time_ns: rig::monotonic_time_ns(),
            wall_clock_time_ns: rig::wall_clock_time_ns(),
        },
        ..RunDescription::default()
    }
}
