//! What the tests of the whole instrument share: a rig of their own, and a look at its processes.
//!
//! Each [`Bench`] has its own runtime directory, so its shared memory and lock meet no other's. The
//! benches of a test binary take turns, since they share the machine's cores.

pub mod browser;
pub mod ethercat;
pub mod guide;
pub mod live_view;
pub mod other_user;
pub mod rotary_plant;
pub mod small_disk;
mod stopped_thread;
pub mod trials;

use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::sync::{Mutex, MutexGuard};
use std::time::{Duration, Instant};

use anyhow::{Context as _, ensure};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
pub use stopped_thread::StoppedThread;

static TURN: Mutex<()> = Mutex::new(());

/// A rig and a folder for captures, both gone when this is dropped.
pub struct Bench {
    folder: tempfile::TempDir,
    _turn: MutexGuard<'static, ()>,
}

impl Bench {
    /// An empty bench, once no other is in use.
    ///
    /// # Errors
    /// When the temporary folder cannot be made.
    pub fn new() -> anyhow::Result<Self> {
        // A test that failed while it had the turn leaves nothing that the next could trip over.
        let turn = TURN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        Ok(Self { folder: tempfile::tempdir()?, _turn: turn })
    }

    /// The folder for files of the test.
    #[must_use]
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// What of its rig lies in shared memory.
    #[must_use]
    pub fn shared_memory(&self) -> Vec<PathBuf> {
        shared_types::clean_up::files_in_shared_memory(&self.path("rig"))
    }

    /// The command `haptic-camera ARGUMENTS` on this bench's rig.
    ///
    /// # Errors
    /// When the programs are not built.
    pub fn command(&self, arguments: &[&str]) -> anyhow::Result<Command> {
        let program = program("haptic-camera")?;
        let mut command = Command::new(program);
        command
            .args(arguments)
            .env(shared_types::rig::RUNTIME_DIR_VARIABLE, self.path("rig"))
            .current_dir(self.folder.path())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        Ok(command)
    }

    /// Runs `haptic-camera ARGUMENTS` to its end.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn run(&self, arguments: &[&str]) -> anyhow::Result<Output> {
        Ok(self.command(arguments)?.output()?)
    }

    /// Starts `haptic-camera ARGUMENTS`.
    ///
    /// # Errors
    /// When it cannot be started.
    pub fn start(&self, arguments: &[&str]) -> anyhow::Result<Child> {
        Ok(self.command(arguments)?.spawn()?)
    }

    /// The only archive under `folder`.
    ///
    /// # Errors
    /// When there is none or more than one.
    pub fn only_archive(&self, folder: &str) -> anyhow::Result<PathBuf> {
        let mut archives: Vec<PathBuf> = std::fs::read_dir(self.path(folder))?
            .flatten()
            .map(|entry| entry.path())
            .filter(|path| path.to_string_lossy().contains(".mcap"))
            .collect();
        ensure!(archives.len() == 1, "one archive was expected, these are there: {archives:?}");
        Ok(archives.remove(0))
    }

    /// Process ids of the running programs called `name` that belong to this bench.
    #[must_use]
    pub fn processes(&self, name: &str) -> Vec<Pid> {
        let mark = format!("{}={}", shared_types::rig::RUNTIME_DIR_VARIABLE, self.path("rig").display());
        let Ok(entries) = std::fs::read_dir("/proc") else { return Vec::new() };
        entries
            .flatten()
            .filter_map(|entry| entry.file_name().to_string_lossy().parse::<i32>().ok())
            .filter(|pid| {
                let folder = PathBuf::from(format!("/proc/{pid}"));
                let command = std::fs::read_to_string(folder.join("comm")).unwrap_or_default();
                let environment = std::fs::read(folder.join("environ")).unwrap_or_default();
                command.trim() == &name[..name.len().min(15)]
                    && environment.split(|&byte| byte == 0).any(|entry| entry == mark.as_bytes())
            })
            .map(Pid::from_raw)
            .collect()
    }

    /// Waits until a program called `name` runs on this bench.
    ///
    /// # Errors
    /// When none has come after ten seconds.
    pub fn wait_for_process(&self, name: &str) -> anyhow::Result<Pid> {
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            if let Some(&pid) = self.processes(name).first() {
                return Ok(pid);
            }
            ensure!(Instant::now() < deadline, "no {name} runs");
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Kills the program called `name` at once, as the kernel would for want of memory.
    ///
    /// # Errors
    /// When none runs.
    pub fn kill(&self, name: &str) -> anyhow::Result<()> {
        Ok(kill(self.wait_for_process(name)?, Signal::SIGKILL)?)
    }

    /// Every process of the instrument that runs on this bench, with its program's name.
    #[must_use]
    pub fn all_processes(&self) -> Vec<(&'static str, Pid)> {
        let programs = ["haptic-camera", "rt-loop", "recorder", "live-fitter", "rerun-viewer"];
        programs.into_iter().flat_map(|name| self.processes(name).into_iter().map(move |pid| (name, pid))).collect()
    }

    /// Waits until every process of the bench has ended; ends those that have not after ten seconds and gives their
    /// number.
    #[must_use]
    pub fn end_orphans(&self) -> usize {
        let deadline = Instant::now() + Duration::from_secs(10);
        loop {
            let left = self.all_processes();
            if left.is_empty() || Instant::now() > deadline {
                for &(_, process) in &left {
                    // One that ends by itself now is none the less late.
                    let _ = kill(process, Signal::SIGKILL);
                }
                return left.len();
            }
            std::thread::sleep(Duration::from_millis(25));
        }
    }

    /// What of this bench's rig lies in shared memory, and which of its processes run.
    #[must_use]
    pub fn leftovers(&self) -> Vec<String> {
        let in_memory = shared_types::clean_up::files_in_shared_memory(&self.path("rig")).into_iter();
        let in_memory = in_memory.map(|path| path.display().to_string());
        in_memory.chain(self.all_processes().into_iter().map(|(name, _)| name.to_owned())).collect()
    }
}

/// Where a program of the workspace lies: beside the program that asks, or above the folder of the test that does.
///
/// # Errors
/// When it is not built.
pub fn program(name: &str) -> anyhow::Result<PathBuf> {
    let own = std::env::current_exe()?;
    let mut places = own.ancestors().skip(1).take(2).map(|folder| folder.join(name));
    let there = places.find(|path| path.exists());
    there.with_context(|| format!("{name} is missing: build the whole workspace first, as scripts/test does"))
}

/// What a program printed, for messages.
#[must_use]
pub fn printed(output: &Output) -> String {
    format!(
        "exit {:?}\n{}{}",
        output.status.code(),
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}
