//! A process that this one starts, how long it has been silent, and its end.

use std::os::unix::process::ExitStatusExt as _;
use std::path::PathBuf;
use std::process::{Command, ExitStatus};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use nix::sys::signal::Signal;
use shared_types::{lease, rig};

use crate::outcome::is_output_json;

/// The command that starts one of our programs, which lie beside this one, for as long as this one lives.
pub(crate) fn program(name: &str) -> anyhow::Result<Command> {
    let mut command = bare_program(name)?;
    // A Ctrl-C at the terminal reaches this program alone, which then ends the run in order.
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    lease::grant(&mut command);
    if is_output_json() {
        command.stdout(std::io::stderr());
    }
    if !operator::log_may_be_coloured() {
        // Their logs go where ours goes.
        command.env("NO_COLOR", "1");
    }
    Ok(command)
}

/// The command that starts one of our programs and no more.
pub(crate) fn bare_program(name: &str) -> anyhow::Result<Command> {
    let path = program_path(name)?;
    anyhow::ensure!(path.exists(), "the program {} is missing; build the whole workspace", path.display());
    Ok(Command::new(path))
}

pub(crate) fn program_path(name: &str) -> anyhow::Result<PathBuf> {
    Ok(std::env::current_exe().context("the location of this program is unknown")?.with_file_name(name))
}

pub(crate) struct Child {
    process: std::process::Child,
    started: Instant,
    /// Time of its last report, CLOCK_MONOTONIC, ns, and the total time that it had waited for a processor by then.
    heard: (u64, Duration),
    /// Since when it was seen to be stopped.
    pub(super) stopped: Option<Instant>,
    /// Whether it was killed; it may take some time to die, if one of its threads waits for the disk.
    is_killed: bool,
}

impl Child {
    pub(crate) fn start(command: &mut Command) -> anyhow::Result<Self> {
        let process = command
            .spawn()
            .with_context(|| format!("{} cannot be started", command.get_program().to_string_lossy()))?;
        let heard = (rig::monotonic_time_ns(), rig::processor_wait(process.id()));
        Ok(Self { process, started: Instant::now(), heard, stopped: None, is_killed: false })
    }

    /// Takes note of when it last said something.
    pub(super) fn hear(&mut self, at_ns: u64) {
        if at_ns > self.heard.0 {
            self.heard = (at_ns, rig::processor_wait(self.id()));
        }
    }

    /// Time since it was started or last heard, without the time for which its main thread waited for a processor: a restart
    /// would only delay it further.
    pub(super) fn silence(&self) -> Duration {
        let (at_ns, waited) = self.heard;
        let waited = rig::processor_wait(self.id()).saturating_sub(waited);
        Duration::from_nanos(rig::monotonic_time_ns().saturating_sub(at_ns)).saturating_sub(waited)
    }

    pub(crate) fn id(&self) -> u32 {
        self.process.id()
    }

    pub(crate) fn age(&self) -> Duration {
        self.started.elapsed()
    }

    /// Whether it has ended; reaps it.
    pub(crate) fn has_ended(&mut self) -> bool {
        self.exit().is_some()
    }

    /// Whether it will do nothing more, even if it cannot be reaped yet.
    pub(super) fn is_over(&mut self) -> bool {
        self.is_killed || self.has_ended() || !rig::process_exists(self.id())
    }

    fn exit(&mut self) -> Option<ExitStatus> {
        self.process.try_wait().ok().flatten()
    }

    /// Its exit code, `None` while it runs or when a signal ended it.
    pub(crate) fn exit_code(&mut self) -> Option<i32> {
        self.exit()?.code()
    }

    pub(crate) fn end_in_words(&mut self) -> String {
        let signal = self.exit().and_then(|status| status.signal()).map(Signal::try_from);
        match (signal, self.exit_code()) {
            (Some(Ok(signal)), _) => format!("it was killed by {signal}"),
            (_, Some(code)) => format!("its exit status is {code}"),
            _ => "its exit status is unknown".to_owned(),
        }
    }

    /// Ends its lease, so that it ends in order.
    pub(crate) fn let_go(&mut self) {
        drop(self.process.stdin.take());
    }

    /// Ends its lease, and kills it if it has not ended within `patience`.
    pub(crate) fn end(&mut self, patience: Duration) {
        self.let_go();
        if !self.wait(patience) {
            self.kill();
            self.wait(Duration::from_secs(1));
        }
    }

    pub(super) fn kill(&mut self) {
        let _ = self.process.kill();
        self.is_killed = true;
    }

    /// Waits for its end; `false` when it has not come within `patience`.
    pub(crate) fn wait(&mut self, patience: Duration) -> bool {
        let deadline = Instant::now() + patience;
        while !self.has_ended() {
            if Instant::now() >= deadline {
                return false;
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        true
    }
}
