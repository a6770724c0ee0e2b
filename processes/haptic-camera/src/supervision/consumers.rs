//! Recorder, live fitter and viewer: started, brought back when they die or hang, ended.

use std::fs::File;
use std::os::unix::fs::FileExt as _;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rt_loop::realtime::OffCore;
use shared_types::{ProcessKind, rig};

use super::child::{Child, program};
use super::loop_link::LoopLink;
use crate::outcome::remark;
use crate::terminal;
use crate::until_ci::Share;

/// Least time between two starts of a process. It doubles with each short life and each start that fails …
const RESTART_PAUSE: Duration = Duration::from_millis(100);
/// … up to this, so that a process which can be started again is back while the samples that it missed still lie in the stream's
/// history of eight seconds.
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// A process that lived for less than this died of something that a restart may not mend.
const SHORT_LIFE: Duration = Duration::from_secs(1);
/// Failures in a row after which the operator is warned.
const REPORTED_FAILURES: u32 = 5;
/// Silence of a consumer, which reports twice a second, after which it counts as hung. The samples that it misses until it is
/// back must still lie in the stream's history.
const HUNG: Duration = Duration::from_millis(2_500);
/// A consumer may take so long until its first report.
const FIRST_WORD: Duration = Duration::from_secs(10);
/// Silence after which a report is overdue, and the kernel is asked what the process does.
const OVERDUE: Duration = Duration::from_millis(500);
/// How long a consumer may be stopped (SIGSTOP) after that silence: another must be at work within a second of the stop.
const STOPPED: Duration = Duration::from_millis(100);
/// After the run, time for which starts are retried of a recorder that cannot be started or dies at once.
const RECORDER_BACK: Duration = Duration::from_secs(10);
/// Most bytes of the consumers' output to print at a time.
const MOST_BYTES: usize = 1 << 16;

pub(crate) struct Consumers {
    /// The recorder first.
    all: Vec<Consumer>,
    words: Words,
}

struct Consumer {
    kind: ProcessKind,
    arguments: Vec<String>,
    /// The control loop's core, which it keeps off.
    loop_core: u32,
    /// Its process, at work or ended; `None` where it could not be started.
    child: Option<Child>,
    starts: u32,
    tried: Instant,
    /// Consecutive short lives and failed starts.
    failures: u32,
}

impl Consumers {
    /// Starts them, off the control loop's core where there is another. Only the recorder is indispensable.
    pub(crate) fn start(
        archive: &Path,
        viewer: Option<&str>,
        until: Option<Share>,
        loop_core: u32,
    ) -> anyhow::Result<Self> {
        // Used only with a panel. Without such a file the consumers' output disturbs the panel, which is no reason not to run.
        let words = Words { file: terminal::size().and_then(|_| tempfile::tempfile().ok()), printed: 0 };
        let consumer = |(kind, argument): (ProcessKind, Option<String>)| Consumer {
            kind,
            arguments: argument.into_iter().collect(),
            loop_core,
            child: None,
            starts: 0,
            tried: Instant::now(),
            failures: 0,
        };
        let share = until.map(|share| format!("--share={}", share.0));
        let always =
            [(ProcessKind::Recorder, Some(format!("--out={}", archive.display()))), (ProcessKind::LiveFitter, share)];
        let viewer = viewer.map(|place| (ProcessKind::Viewer, Some(place.to_owned())));
        let mut all: Vec<Consumer> = always.into_iter().chain(viewer).map(consumer).collect();
        all[0].start(&words)?;
        all[1..].iter_mut().for_each(|consumer| consumer.try_to_start(&words));
        Ok(Self { all, words })
    }

    pub(crate) fn revive(&mut self, link: &LoopLink) {
        self.words.tell();
        for consumer in &mut self.all {
            consumer.end_if_hung(link);
            consumer.revive(&self.words);
        }
    }

    /// Waits for the recorder to close the archive; gives its exit code. A recorder that dies is started again while
    /// `source_lives`: it must hear from the control loop.
    pub(crate) fn finish_recorder(
        &mut self,
        patience: Duration,
        mut source_lives: impl FnMut() -> bool,
    ) -> Option<i32> {
        let Self { all, words } = self;
        let recorder = &mut all[0];
        let deadline = Instant::now() + patience;
        let mut seen_alive = Instant::now();
        while Instant::now() < deadline {
            let source_lives = source_lives();
            words.tell();
            recorder.end_if_stopped();
            if recorder.is_away() {
                let exit = recorder.child.as_mut().and_then(Child::exit_code);
                if matches!(exit, Some(0 | 3)) || !source_lives || seen_alive.elapsed() > RECORDER_BACK {
                    return exit;
                }
                recorder.revive(words);
            } else if recorder.has_lived() {
                seen_alive = Instant::now();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        let child = recorder.child.as_mut()?;
        child.end(Duration::from_secs(5));
        child.exit_code()
    }

    /// Ends whatever still runs; gives the restarts of each.
    pub(crate) fn end(mut self) -> Vec<(ProcessKind, u32)> {
        let mut children: Vec<&mut Child> = self.all.iter_mut().filter_map(|one| one.child.as_mut()).collect();
        children.iter_mut().for_each(|child| child.let_go());
        children.iter_mut().for_each(|child| child.end(Duration::from_secs(4)));
        self.words.tell();
        self.all.iter().map(|consumer| (consumer.kind, consumer.starts.saturating_sub(1))).collect()
    }
}

impl Consumer {
    /// Starts its process off the control loop's core, where releasing the process's memory would take time from a tick.
    fn start(&mut self, words: &Words) -> anyhow::Result<()> {
        self.tried = Instant::now();
        self.child = None;
        let _elsewhere = OffCore::leave(self.loop_core);
        let mut command = program(self.kind.name())?;
        command.args(&self.arguments).arg(format!("--restarts={}", self.starts));
        if let Some(file) = &words.file
            && let (Ok(output), Ok(errors)) = (file.try_clone(), file.try_clone())
        {
            command.stdout(output).stderr(errors);
        }
        if self.starts > 0 {
            // What it prints at its start has been printed.
            command.stdout(Stdio::null());
        }
        self.child = Some(Child::start(&mut command)?);
        self.starts += 1;
        Ok(())
    }

    /// Starts it, or tells that it cannot be started yet.
    fn try_to_start(&mut self, words: &Words) {
        if let Err(error) = self.start(words) {
            self.failures += 1;
            if self.failures == 1 {
                remark(format!("{} cannot be started: {error:#}; retrying", self.kind.name()));
            }
        }
    }

    fn is_away(&mut self) -> bool {
        self.child.as_mut().is_none_or(Child::is_over)
    }

    /// Whether its current or last process is older than [`SHORT_LIFE`].
    fn has_lived(&self) -> bool {
        self.child.as_ref().is_some_and(|child| child.age() >= SHORT_LIFE)
    }

    /// Ends it if it hangs: it then counts as one that died.
    fn end_if_hung(&mut self, link: &LoopLink) {
        let Some(child) = &mut self.child else { return };
        let mut patience = FIRST_WORD;
        if let Some(health) = link.health.iter().find(|health| health.process_id == child.id()) {
            child.hear(health.monotonic_time_ns);
            patience = HUNG;
        }
        // One that waits for a disk is left to wait.
        if child.silence() > patience && rig::process_state(child.id()) != Some('D') {
            self.end_at_once();
        }
        self.end_if_stopped();
    }

    /// Ends it if a signal has stopped it: it then counts as one that died.
    fn end_if_stopped(&mut self) {
        let Some(child) = &mut self.child else { return };
        if child.silence() < OVERDUE || rig::process_state(child.id()) != Some('T') {
            child.stopped = None;
        } else if child.stopped.get_or_insert_with(Instant::now).elapsed() > STOPPED {
            self.end_at_once();
        }
    }

    fn end_at_once(&mut self) {
        if let Some(child) = &mut self.child
            && !child.is_over()
        {
            remark(format!("{} does not respond and is restarted", self.kind.name()));
            child.kill();
        }
    }

    /// Starts it again if it has ended, however that came.
    fn revive(&mut self, words: &Words) {
        let is_away = self.is_away();
        let has_lived = self.has_lived();
        if has_lived {
            if !is_away && self.failures >= REPORTED_FAILURES {
                remark(format!("{} is back", self.kind.name()));
            }
            self.failures = 0;
        }
        let pause = RESTART_PAUSE.saturating_mul(1 << self.failures.min(10)).min(LONGEST_PAUSE);
        if !is_away || self.tried.elapsed() < pause {
            return;
        }
        if self.child.take().is_some() && !has_lived {
            self.failures += 1;
            if self.failures == REPORTED_FAILURES {
                remark(format!("{} keeps dying; it is restarted each time", self.kind.name()));
            }
        }
        self.try_to_start(words);
    }
}

/// An unnamed file that the consumers print to. Unlike a pipe it never fills up, and writing to it does not fail after this
/// process is gone.
struct Words {
    file: Option<File>,
    printed: u64,
}

impl Words {
    /// Prints the lines that are complete, longer ones than so many bytes in pieces.
    fn tell(&mut self) {
        let Some(file) = &self.file else { return };
        while file.metadata().is_ok_and(|file| file.len() > self.printed) {
            let mut bytes = vec![0; MOST_BYTES];
            let read = file.read_at(&mut bytes, self.printed).unwrap_or(0);
            let complete = bytes[..read].iter().rposition(|&byte| byte == b'\n').map(|end| end + 1);
            let Some(end) = complete.or((read == MOST_BYTES).then_some(read)) else { return };
            self.printed += end as u64;
            String::from_utf8_lossy(&bytes[..end]).lines().for_each(remark);
        }
    }
}
