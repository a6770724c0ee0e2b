//! Recorder, live fitter and viewer: started, brought back when they die or hang, ended.

use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use nix::sys::signal::{Signal, kill};
use rt_loop::realtime::OffCore;
use shared_types::{ProcessKind, rig};

use super::child::{Child, program};
use super::loop_link::LoopLink;
use super::words::Words;
use crate::command_line::RunOptions;
use crate::outcome::remark;
use crate::terminal;

/// Pause before a process that died is started again.
const RESTART_PAUSE: Duration = Duration::from_millis(100);
/// A process that lived for less than this died of something that a restart may not mend.
const SHORT_LIFE: Duration = Duration::from_secs(1);
/// Short lives in a row after which a process is given up.
const SHORT_LIVES: u32 = 5;
/// Silence of a consumer, which reports twice a second, after which it counts as hung; the time that it waited for a
/// processor does not count. What it missed until it is back must still lie in the stream's history of eight seconds.
const HUNG: Duration = Duration::from_millis(2_500);
/// A consumer may take so long until its first report.
const FIRST_WORD: Duration = Duration::from_secs(10);
/// Silence after which a report is overdue, and the kernel is asked what the process does.
const OVERDUE: Duration = Duration::from_millis(500);
/// How long a consumer may be stopped (SIGSTOP) from then on: another is to be at work within a second of the stop.
const STOPPED: Duration = Duration::from_millis(100);

/// One consumer and how to start it again.
struct Consumer {
    kind: ProcessKind,
    arguments: Vec<String>,
    /// The control loop's core, which it keeps off.
    loop_core: u32,
    child: Child,
    /// When it last said how it is or was started, and how long it had waited for a processor until then.
    heard: Heard,
    /// Since when it was seen to be stopped.
    stopped: Option<Instant>,
    restarts: u32,
    short_lives: u32,
    given_up: bool,
}

#[derive(Clone, Copy)]
struct Heard {
    /// CLOCK_MONOTONIC, ns.
    at_ns: u64,
    processor_wait: Duration,
}

impl Heard {
    fn at_its_start() -> Self {
        Self { at_ns: rig::monotonic_time_ns(), processor_wait: Duration::ZERO }
    }

    /// Silence since, for which the process had a processor.
    fn silence(&self, process_id: u32) -> Duration {
        let waited = rig::processor_wait(process_id).saturating_sub(self.processor_wait);
        Duration::from_nanos(rig::monotonic_time_ns().saturating_sub(self.at_ns)).saturating_sub(waited)
    }
}

impl Consumer {
    fn start(kind: ProcessKind, arguments: Vec<String>, loop_core: u32, words: &Words) -> anyhow::Result<Self> {
        let child = spawn(kind, &arguments, loop_core, 0, words)?;
        let heard = Heard::at_its_start();
        Ok(Self {
            kind,
            arguments,
            loop_core,
            child,
            heard,
            stopped: None,
            restarts: 0,
            short_lives: 0,
            given_up: false,
        })
    }

    /// Ends it if it hangs: it then counts as one that died.
    fn end_if_hung(&mut self, link: &LoopLink) {
        let process_id = self.child.id();
        let last_word = link.last_word_of(process_id);
        if let Some(at_ns) = last_word.filter(|at_ns| *at_ns > self.heard.at_ns) {
            self.heard = Heard { at_ns, processor_wait: rig::processor_wait(process_id) };
        }
        let patience = if last_word.is_some() { HUNG } else { FIRST_WORD };
        // One that waits for a disk is left to wait.
        if self.heard.silence(process_id) > patience && rig::process_state(process_id) != Some('D') {
            self.end_at_once();
        }
        self.end_if_stopped();
    }

    /// Ends it if a signal has stopped it: it then counts as one that died.
    fn end_if_stopped(&mut self) {
        let process_id = self.child.id();
        if self.heard.silence(process_id) < OVERDUE || rig::process_state(process_id) != Some('T') {
            self.stopped = None;
        } else if self.stopped.get_or_insert_with(Instant::now).elapsed() > STOPPED {
            self.end_at_once();
        }
    }

    fn end_at_once(&mut self) {
        if !self.child.has_ended() {
            remark(format!("{} no longer answers and is started again", self.kind.name()));
            let _ = kill(self.child.pid(), Signal::SIGKILL);
            self.child.wait(Duration::from_secs(1));
        }
    }

    /// Starts it again if it died. A clean end is left as it is.
    fn revive(&mut self, words: &Words) {
        if self.given_up || !self.child.has_ended() || self.ended_in_order() {
            return;
        }
        if self.child.age() < RESTART_PAUSE {
            return;
        }
        self.short_lives = if self.child.age() < SHORT_LIFE { self.short_lives + 1 } else { 0 };
        if self.short_lives >= SHORT_LIVES {
            self.given_up = true;
            remark(format!("{} dies again and again and is left out; the run goes on", self.kind.name()));
            return;
        }
        self.restarts += 1;
        match spawn(self.kind, &self.arguments, self.loop_core, self.restarts, words) {
            Ok(child) => {
                self.heard = Heard::at_its_start();
                self.stopped = None;
                self.child = child;
            }
            Err(error) => {
                self.given_up = true;
                remark(format!("{} cannot be started again: {error:#}", self.kind.name()));
            }
        }
    }

    fn ended_in_order(&self) -> bool {
        matches!(self.child.exit_code(), Some(0 | 3))
    }
}

/// Starts it off the control loop's core, where the end of its memory would be a tick's business too.
fn spawn(
    kind: ProcessKind,
    arguments: &[String],
    loop_core: u32,
    restarts: u32,
    words: &Words,
) -> anyhow::Result<Child> {
    let _elsewhere = OffCore::leave(loop_core);
    let mut command = program(kind.name())?;
    command.args(arguments).arg(format!("--restarts={restarts}"));
    words.take_from(&mut command);
    if restarts > 0 {
        // What it had to say at its start has been said.
        command.stdout(Stdio::null());
    }
    Child::start(&mut command)
}

/// Recorder, live fitter and viewer.
pub(crate) struct Consumers {
    recorder: Consumer,
    others: Vec<Consumer>,
    words: Words,
}

impl Consumers {
    /// Starts them, off the control loop's core where there is another. Only the recorder is indispensable.
    pub(crate) fn start(archive: &Path, options: &RunOptions, loop_core: u32) -> anyhow::Result<Self> {
        let words = Words::apart_from_panel(terminal::size().is_some());
        let out = vec![format!("--out={}", archive.display())];
        let recorder = Consumer::start(ProcessKind::Recorder, out, loop_core, &words)?;
        let mut wanted = vec![(ProcessKind::LiveFitter, Vec::new())];
        if !options.no_viewer {
            let place = if options.native_viewer { "--native" } else { "--web" };
            wanted.push((ProcessKind::Viewer, vec![place.to_owned()]));
        }
        let mut others = Vec::new();
        for (kind, arguments) in wanted {
            match Consumer::start(kind, arguments, loop_core, &words) {
                Ok(consumer) => others.push(consumer),
                Err(error) => remark(format!("going on without {}: {error:#}", kind.name())),
            }
        }
        Ok(Self { recorder, others, words })
    }

    /// Starts again what has died or hangs.
    pub(crate) fn revive(&mut self, link: &LoopLink) {
        let Self { recorder, others, words } = self;
        words.tell();
        for consumer in others.iter_mut().chain([recorder]) {
            consumer.end_if_hung(link);
            consumer.revive(words);
        }
    }

    /// Waits for the recorder to close the archive, starting it again if it dies on the way; gives its exit code.
    pub(crate) fn finish_recorder(&mut self, patience: Duration, mut meanwhile: impl FnMut()) -> Option<i32> {
        let deadline = Instant::now() + patience;
        while Instant::now() < deadline {
            meanwhile();
            self.words.tell();
            self.recorder.end_if_stopped();
            self.recorder.revive(&self.words);
            if self.recorder.given_up || (self.recorder.child.has_ended() && self.recorder.ended_in_order()) {
                return self.recorder.child.exit_code();
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        self.recorder.child.end(Duration::from_secs(5));
        self.recorder.child.exit_code()
    }

    /// Ends whatever still runs; gives the restarts of each.
    pub(crate) fn end(mut self) -> Vec<(ProcessKind, u32)> {
        for consumer in &mut self.others {
            let _ = kill(consumer.child.pid(), Signal::SIGTERM);
        }
        let mut restarts = vec![(self.recorder.kind, self.recorder.restarts)];
        for consumer in &mut self.others {
            consumer.child.end(Duration::from_secs(2));
            restarts.push((consumer.kind, consumer.restarts));
        }
        self.recorder.child.end(Duration::from_secs(2));
        self.words.tell();
        restarts
    }
}
