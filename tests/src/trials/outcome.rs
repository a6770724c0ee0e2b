//! What came of a trial, and which promises it broke.

use std::os::unix::fs::MetadataExt as _;
use std::path::Path;
use std::time::Duration;

use anyhow::Context as _;
use archive::Capture;
use nix::sys::signal::{Signal, kill};
use shared_types::rig::monotonic_time_ns;
use shared_types::{LoopState, ProcessKind, clean_up, fault_injection, shared_memory};

use super::watched::Watched;
use super::{EarlyKills, Evidence, Fault, Trial, Victim};
use crate::Bench;

/// How long a stopped process stays stopped.
const STOPPED: Duration = Duration::from_secs(5);
/// Longest time until a whole run must have ended.
const PATIENCE: Duration = Duration::from_secs(90);
/// Kills of one trial of killing early, and the latest moment of each.
const EARLY: (u32, Duration) = (5, Duration::from_millis(50));
/// Messages that a run did not reach its planned end.
const REPORTED_ENDS: [&str; 4] =
    ["were never taken", "ended in the middle of the run", "the run ended in a fault", "stopped by the operator"];
/// Messages that a run never began.
const NOTHING_BEGAN: &str = "the control loop ended before";
/// Longest time until a process is back, and until a lost source is reported, s.
const PROMPT_S: f64 = 1.0;

/// What came of one trial.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Every promise that was broken, in words; empty is how it should be.
    pub broken: Vec<String>,
    /// What came later than promised, in words: a figure of the machine too, so that tests leave it to the study.
    pub late: Vec<String>,
    /// Samples that were published and are not in the archive.
    pub lost_samples: u64,
    /// Samples planned or published that are neither in the archive nor reported missing.
    pub lost_unsaid: u64,
    /// Processes of the run that did not end with it.
    pub orphans: usize,
    /// Time from the fault to the first report of the process that took the victim's place, s.
    pub back_after_s: Option<f64>,
    /// Time from the loss of the control loop until the last of supervisor and recorder had reported it, s.
    pub reported_after_s: Option<f64>,
    /// See [`Evidence::rank_of_lateness`].
    pub lateness_rank: Option<f64>,
    /// Ticks missed in the half second after the fault.
    pub missed_after_fault: u64,
    /// Ticks missed in the whole run.
    pub missed_in_run: u64,
    /// Memory that the rig's files held in shared memory shortly before the run's end, bytes.
    pub shared_memory_bytes: u64,
}

impl Trial {
    /// Makes the capture with its fault on an empty bench.
    ///
    /// # Errors
    /// When the trial could not be made; a broken promise is no error.
    pub fn run(&self, bench: &Bench) -> anyhow::Result<Outcome> {
        let mut outcome =
            if self.fault == Fault::KilledEarly { self.kill_early(bench)? } else { self.disturb_capture(bench)? };
        if !self.victim.is_consumer() {
            outcome.expect_new_capture(bench)?;
        }
        let left = bench.leftovers();
        outcome.expect(left.is_empty(), || format!("left behind: {left:?}"));
        Ok(outcome)
    }

    fn kill_early(&self, bench: &Bench) -> anyhow::Result<Outcome> {
        let (kills, latest) = EARLY;
        let orphans = EarlyKills { kills, latest, seed: self.seed }.orphans(bench)?;
        Ok(Outcome { orphans, ..Outcome::default() })
    }

    fn disturb_capture(&self, bench: &Bench) -> anyhow::Result<Outcome> {
        let duration = format!("{}", self.duration_s);
        let mut arguments = vec!["capture", "--duration-s", &duration, "--out", "out"];
        if self.victim != Victim::Viewer {
            arguments.push("--no-viewer");
        }
        let mut command = bench.command(&arguments)?;
        command.env(fault_injection::FAULT_INJECTION_VARIABLE, "1");
        let program = Watched::start(command)?;
        bench.wait_for_process(ProcessKind::Recorder.name())?;
        std::thread::sleep(Duration::from_secs_f64(self.moment_s));
        let victim = bench.wait_for_process(self.victim.program())?;
        let fault_ns = monotonic_time_ns();
        kill(victim, self.fault.signal()).context("the victim had ended by itself")?;
        if self.fault == Fault::Stopped {
            std::thread::sleep(STOPPED);
            // A consumer that hung was ended by the supervisor meanwhile.
            let _ = kill(victim, Signal::SIGCONT);
        } else if self.victim.is_consumer() {
            std::thread::sleep(Duration::from_secs_f64((self.duration_s - self.moment_s - 1.0).max(0.0)));
        }
        let shared_memory_bytes = shared_memory_bytes(&bench.path("rig"));
        let (status, said) = program.wait(PATIENCE)?;

        let mut outcome = Outcome { shared_memory_bytes, orphans: bench.end_orphans(), ..Outcome::default() };
        let needed = shared_memory::NEEDED_BYTES;
        outcome.expect(shared_memory_bytes <= needed, || format!("{shared_memory_bytes} bytes of {needed} needed"));
        if said.iter().any(|(_, line)| line.contains(NOTHING_BEGAN)) {
            // On a busy machine the fault came before the run: there is nothing to lose.
            outcome.expect(status.code() == Some(1), || format!("exit {status} of a run that never began"));
            return Ok(outcome);
        }
        outcome.expect_exit(self, status.code());
        let archive = match bench.only_archive("out") {
            Ok(archive) => archive,
            Err(error) => {
                outcome.broken.push(format!("{error:#}; {said:?}"));
                return Ok(outcome);
            }
        };
        let evidence = Evidence::read(&archive).context("the archive is not whole")?;
        outcome.look_at_archive(self, &evidence, &Capture::load(&archive)?, &said);
        outcome.lateness_rank = evidence.rank_of_lateness(fault_ns);
        (outcome.missed_after_fault, outcome.missed_in_run) = evidence.missed_ticks(fault_ns);
        match self.victim {
            Victim::ControlLoop => outcome.look_at_end(self, &said, fault_ns),
            Victim::Supervisor => {}
            _ => outcome.look_at_return(self, &evidence, u32::try_from(victim.as_raw())?, fault_ns),
        }
        Ok(outcome)
    }

    /// Exit code of the command that the operator started; `None` when a signal ended it.
    fn expected_exit(&self) -> Option<i32> {
        match (self.victim, self.fault) {
            (Victim::ControlLoop, Fault::Terminated | Fault::HungUp) => Some(3),
            (Victim::ControlLoop, _) => Some(1),
            (Victim::Supervisor, Fault::Killed) => None,
            (Victim::Supervisor, Fault::Panic) => Some(101),
            _ => Some(0),
        }
    }
}

impl Outcome {
    fn expect(&mut self, is_kept: bool, promise: impl FnOnce() -> String) {
        if !is_kept {
            self.broken.push(promise());
        }
    }

    fn expect_exit(&mut self, trial: &Trial, exit: Option<i32>) {
        let expected = trial.expected_exit();
        self.expect(exit == expected, || format!("exit {exit:?} instead of {expected:?}"));
    }

    /// No sample is missing, or the archive itself says which.
    fn look_at_archive(&mut self, trial: &Trial, evidence: &Evidence, capture: &Capture, said: &[(u64, String)]) {
        let published = evidence.published_samples();
        self.lost_samples = published - evidence.samples.len() as u64;
        let holes = evidence.holes();
        self.expect(holes.is_empty(), || format!("holes in the archive: {holes:?}"));
        let reported = capture.lost_samples();
        let lost = self.lost_samples;
        self.expect(reported == lost, || format!("{lost} samples are missing, {reported} are reported missing"));
        let in_order = evidence.samples.windows(2).all(|pair| pair[0].tick < pair[1].tick);
        self.expect(in_order, || "ticks out of order".to_owned());
        let planned = capture.description.as_ref().map_or(0, |run| run.planned_ticks);
        // A sample that is lost takes with it how many ticks were missed before it; the loop has counted them too.
        let seen: u64 = evidence.samples.iter().map(|sample| u64::from(sample.missed_ticks)).sum();
        let missed = evidence.statuses.iter().map(|status| status.missed_ticks).fold(seen, u64::max);
        let ticks = evidence.samples.len() as u64 + missed;
        if trial.victim.is_consumer() || (trial.victim, trial.fault) == (Victim::Supervisor, Fault::Stopped) {
            let accounted = ticks + reported;
            self.expect(accounted == planned, || {
                format!("{accounted} ticks are accounted for, {planned} were planned")
            });
        }
        // Whoever would say it is dead itself.
        let nobody_can_say = trial.victim == Victim::Supervisor && matches!(trial.fault, Fault::Killed | Fault::Panic);
        let is_reported = said.iter().any(|(_, line)| REPORTED_ENDS.iter().any(|end| line.contains(end)));
        let unaccounted = if is_reported || nobody_can_say { 0 } else { planned.saturating_sub(ticks + reported) };
        self.lost_unsaid = lost.saturating_sub(reported).max(unaccounted);
        if (trial.victim, trial.fault) == (Victim::ControlLoop, Fault::Stopped) {
            let last = evidence.samples.last().and_then(|sample| LoopState::from_code(sample.state));
            self.expect(last == Some(LoopState::Fault), || format!("the run ended in {last:?} instead of a fault"));
        }
    }

    /// A consumer that died or was stopped is back within a second.
    fn look_at_return(&mut self, trial: &Trial, evidence: &Evidence, process_id: u32, fault_ns: u64) {
        let kind = match trial.victim {
            Victim::Recorder => ProcessKind::Recorder,
            Victim::LiveFitter => ProcessKind::LiveFitter,
            _ => ProcessKind::Viewer,
        };
        let reports = evidence.reports(kind);
        // One that was stopped may go on by itself, on a machine that kept its supervisor from looking.
        // A signal that asks it to end is left to the supervisor.
        let may_go_on = matches!(trial.fault, Fault::Stopped | Fault::Terminated | Fault::HungUp);
        let back =
            reports.iter().find(|&&(process, time_ns)| time_ns > fault_ns && (may_go_on || process != process_id));
        self.back_after_s = back.map(|&(_, time_ns)| seconds(time_ns - fault_ns));
        self.expect(self.back_after_s.is_some(), || format!("{} did not come back", kind.name()));
        if let Some(back_after_s) = self.back_after_s.filter(|&back_after_s| back_after_s >= PROMPT_S) {
            self.late.push(format!("{} was back after {back_after_s:.2} s instead of {PROMPT_S} s", kind.name()));
        }
    }

    /// Supervisor and recorder say within a second that their source is gone.
    fn look_at_end(&mut self, trial: &Trial, said: &[(u64, String)], fault_ns: u64) {
        if matches!(trial.fault, Fault::Stopped | Fault::Terminated | Fault::HungUp) {
            return;
        }
        for word in
            ["the control loop ended in the middle of the run", "the control loop died before the end of the run"]
        {
            let Some((time_ns, _)) = said.iter().find(|(_, line)| line.contains(word)) else {
                self.broken.push(format!("nobody said that {word}: {said:?}"));
                continue;
            };
            let after_s = seconds(time_ns.saturating_sub(fault_ns));
            self.reported_after_s = Some(self.reported_after_s.map_or(after_s, |before_s| before_s.max(after_s)));
            if after_s >= PROMPT_S {
                self.late.push(format!("{word}: reported after {after_s:.2} s only"));
            }
        }
    }

    fn expect_new_capture(&mut self, bench: &Bench) -> anyhow::Result<()> {
        let output = bench.run(&["capture", "--duration-s", "1", "--no-viewer", "--out", "again"])?;
        self.expect(output.status.success(), || format!("no new capture at once: {}", crate::printed(&output)));
        Ok(())
    }
}

/// Memory that files of the rig hold in shared memory, bytes.
#[must_use]
pub(super) fn shared_memory_bytes(runtime_dir: &Path) -> u64 {
    let files = clean_up::files_in_shared_memory(runtime_dir).into_iter();
    files.filter_map(|file| std::fs::metadata(file).ok()).map(|metadata| metadata.blocks() * 512).sum()
}

fn seconds(nanoseconds: u64) -> f64 {
    nanoseconds as f64 / 1e9
}
