//! One consumer: started, brought back when it dies or hangs.

use std::process::Stdio;
use std::time::{Duration, Instant};

use rt_loop::realtime::OffCore;
use shared_types::{ProcessKind, rig};

use super::child::{Child, program};
use super::loop_link::LoopLink;
use super::words::Words;
use crate::outcome::remark;

/// Least time between two starts of a process. It doubles with each short life and each start that fails …
const RESTART_PAUSE: Duration = Duration::from_millis(100);
/// … up to this, so that one which can be started again is back while what it missed still lies in the stream's history of
/// eight seconds.
const LONGEST_PAUSE: Duration = Duration::from_secs(2);
/// A process that lived for less than this died of something that a restart may not mend.
const SHORT_LIFE: Duration = Duration::from_secs(1);
/// Failures in a row after which the operator is warned.
const REPORTED_FAILURES: u32 = 5;
/// Silence of a consumer, which reports twice a second, after which it counts as hung. What it missed until it is back must
/// still lie in the stream's history.
const HUNG: Duration = Duration::from_millis(2_500);
/// A consumer may take so long until its first report.
const FIRST_WORD: Duration = Duration::from_secs(10);
/// Silence after which a report is overdue, and the kernel is asked what the process does.
const OVERDUE: Duration = Duration::from_millis(500);
/// How long a consumer may be stopped (SIGSTOP) from then on: another is to be at work within a second of the stop.
const STOPPED: Duration = Duration::from_millis(100);

/// One consumer and how to start it again.
pub(super) struct Consumer {
    pub(super) kind: ProcessKind,
    arguments: Vec<String>,
    /// The control loop's core, which it keeps off.
    loop_core: u32,
    /// `None` where it could not be started.
    life: Option<Life>,
    starts: u32,
    tried: Instant,
    /// Short lives and starts that failed, in a row.
    failures: u32,
}

/// One process that does a consumer's work, from its start to its end.
struct Life {
    child: Child,
    /// Since when it was seen to be stopped.
    stopped: Option<Instant>,
    /// Whether it was killed. It may be some time in dying, if a thread of it waits for the disk.
    is_killed: bool,
}

impl Consumer {
    pub(super) fn new(kind: ProcessKind, arguments: Vec<String>, loop_core: u32) -> Self {
        Self { kind, arguments, loop_core, life: None, starts: 0, tried: Instant::now(), failures: 0 }
    }

    /// Starts its process off the control loop's core, where the end of its memory would be a tick's business too.
    pub(super) fn start(&mut self, words: &Words) -> anyhow::Result<()> {
        self.tried = Instant::now();
        self.life = None;
        let _elsewhere = OffCore::leave(self.loop_core);
        let mut command = program(self.kind.name())?;
        command.args(&self.arguments).arg(format!("--restarts={}", self.starts));
        words.take_from(&mut command);
        if self.starts > 0 {
            // What it had to say at its start has been said.
            command.stdout(Stdio::null());
        }
        self.life = Some(Life { child: Child::start(&mut command)?, stopped: None, is_killed: false });
        self.starts += 1;
        Ok(())
    }

    /// Starts it, or tells that it cannot be started yet.
    pub(super) fn try_to_start(&mut self, words: &Words) {
        if let Err(error) = self.start(words) {
            self.failures += 1;
            if self.failures == 1 {
                remark(format!("{} cannot be started: {error:#}; retrying", self.kind.name()));
            }
        }
    }

    /// Whether no process does its work.
    pub(super) fn is_away(&mut self) -> bool {
        self.life.as_mut().is_none_or(Life::is_over)
    }

    /// Whether the process that does its work, or did it last, has lived for longer than one that fails at once.
    pub(super) fn has_lived(&self) -> bool {
        self.life.as_ref().is_some_and(|life| life.child.age() >= SHORT_LIFE)
    }

    /// Its process, at work or ended.
    pub(super) fn child(&mut self) -> Option<&mut Child> {
        self.life.as_mut().map(|life| &mut life.child)
    }

    /// Ends it if it hangs: it then counts as one that died.
    pub(super) fn end_if_hung(&mut self, link: &LoopLink) {
        let Some(life) = &mut self.life else { return };
        let process_id = life.child.id();
        let last_word = link.last_word_of(process_id);
        if let Some(at_ns) = last_word {
            life.child.hear(at_ns);
        }
        let patience = if last_word.is_some() { HUNG } else { FIRST_WORD };
        // One that waits for a disk is left to wait.
        if life.child.silence() > patience && rig::process_state(process_id) != Some('D') {
            life.end_at_once(self.kind);
        }
        self.end_if_stopped();
    }

    /// Ends it if a signal has stopped it: it then counts as one that died.
    pub(super) fn end_if_stopped(&mut self) {
        let Some(life) = &mut self.life else { return };
        if life.child.silence() < OVERDUE || rig::process_state(life.child.id()) != Some('T') {
            life.stopped = None;
        } else if life.stopped.get_or_insert_with(Instant::now).elapsed() > STOPPED {
            life.end_at_once(self.kind);
        }
    }

    /// Starts it again if it has ended, however that came.
    pub(super) fn revive(&mut self, words: &Words) {
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
        if self.life.take().is_some() && !has_lived {
            self.failures += 1;
            if self.failures == REPORTED_FAILURES {
                remark(format!("{} keeps dying; it is restarted each time", self.kind.name()));
            }
        }
        self.try_to_start(words);
    }

    pub(super) fn restarts(&self) -> u32 {
        self.starts.saturating_sub(1)
    }
}

impl Life {
    /// Whether it will do nothing more, be it that it cannot be reaped so far.
    fn is_over(&mut self) -> bool {
        self.is_killed || self.child.has_ended() || !rig::process_exists(self.child.id())
    }

    fn end_at_once(&mut self, kind: ProcessKind) {
        if !self.is_over() {
            remark(format!("{} does not respond and is restarted", kind.name()));
            self.child.kill();
            self.is_killed = true;
        }
    }
}
