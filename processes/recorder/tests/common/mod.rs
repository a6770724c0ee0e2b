//! A rig without a control loop, and the recorder on it.
#![allow(dead_code, reason = "no test needs all of it")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use archive::Capture;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections as _;
use shared_types::services::{self, FIT_UPDATES, LOOP_STATUS, MessagePublisher, RigNode, SamplePublisher};
use shared_types::{
    BlockHeader, ClockMapping, FitUpdate, LoopStatus, PrivateIpc, RunDescription, Sample, clean_up, rig,
};
use tempfile::TempDir;

pub const RUN_ID: u64 = 0xfeed;
pub const RATE_HZ: f64 = 10_000.0;

/// The runtime directory is a variable of the whole process: one rig at a time is set up.
static ENVIRONMENT: Mutex<()> = Mutex::new(());

/// Stands in for the control loop: publishes samples as it does, in this test's own rig.
pub struct Rig {
    samples: SamplePublisher,
    status: MessagePublisher<LoopStatus>,
    fits: MessagePublisher<FitUpdate>,
    description: Publisher<PrivateIpc, [u8], ()>,
    pub published: u64,
    pub process_id: u32,
    _node: RigNode,
    _shared_memory: SharedMemory,
    pub directory: TempDir,
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
pub struct Process(pub Child);

impl Process {
    pub fn start(command: &mut Command) -> Self {
        Self(command.spawn().unwrap())
    }

    pub fn kill(&mut self) {
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
    pub fn new() -> Self {
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
            description: services::RUN_DESCRIPTION.publisher(&node).unwrap(),
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

    pub fn describe(&mut self) {
        let json = serde_json::to_vec(&description(RUN_ID)).unwrap();
        self.description.loan_slice_uninit(json.len()).unwrap().write_from_slice(&json).send().unwrap();
    }

    pub fn out(&self) -> PathBuf {
        self.directory.path().join("run.mcap")
    }

    /// The temporary directory as the recorder sees it.
    pub fn elsewhere(&self) -> PathBuf {
        self.directory.path().join("elsewhere")
    }

    /// Where it goes on when the folder that was asked for fails.
    pub fn fallback(&self) -> PathBuf {
        let run = archive::parts::fallback_dir(RUN_ID);
        self.elsewhere().join(run.file_name().unwrap())
    }

    pub fn start_recorder(&self, restarts: u32) -> Process {
        self.start_recorder_to(&self.out(), restarts)
    }

    pub fn start_recorder_to(&self, out: &Path, restarts: u32) -> Process {
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
    pub fn publish_blocks(&mut self, blocks: usize) {
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

    pub fn publish_block_of(&mut self, run_id: u64) {
        let block: Vec<Sample> = (0..10).map(|offset| sample(self.published + offset)).collect();
        let mut loan = self.samples.loan_slice_uninit(block.len()).unwrap();
        *loan.user_header_mut() = BlockHeader { run_id };
        loan.write_from_slice(&block).send().unwrap();
        self.published += 10;
    }

    pub fn publish_status(&self, finished: bool) {
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
    pub fn finish(&self, recorder: &mut Process) -> i32 {
        self.wait(recorder, || {
            self.publish_status(true);
            self.samples.update_connections().unwrap();
            self.description.update_connections().unwrap();
        })
    }

    /// Waits for the recorder to end; its exit status.
    pub fn wait(&self, recorder: &mut Process, meanwhile: impl Fn()) -> i32 {
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

    pub fn wait_for(&mut self, what: &str, mut there: impl FnMut(&Path) -> bool) {
        let started = Instant::now();
        while !there(self.directory.path()) {
            assert!(started.elapsed() < Duration::from_secs(60), "{what} does not come");
            self.publish_blocks(1);
        }
    }

    /// Asserts that the archive holds every published sample, bit for bit.
    pub fn assert_complete(&self, archive: &Path) {
        let capture = Capture::load(archive).unwrap();
        assert_eq!(capture.len() as u64, self.published);
        assert_eq!(capture.gaps, []);
        for (row, (&seq, &torque)) in capture.seq.iter().zip(&capture.torque_mnm).enumerate() {
            assert_eq!(seq, row as u64);
            assert_eq!(torque.to_bits(), sample(seq).torque_mnm.to_bits());
        }
    }
}

pub fn sample(seq: u64) -> Sample {
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
pub fn files_in(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name.contains("mcap"))
        .collect();
    names.sort();
    names
}

pub fn description(run_id: u64) -> RunDescription {
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
