//! A run of the rig: the control loop and its consumers, started, watched and ended together.

mod child;
mod consumers;
mod interrupt;
mod loop_link;
mod progress;
mod run_end;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use archive::{Claim, Overview};
use rt_loop::LONGEST_PREPARATION_S;
use rt_loop::request::RunRequest;
use shared_types::clean_up::files_in_shared_memory;
use shared_types::fault_injection::{self, FaultInjection};
use shared_types::{CommandKind, Fault, LoopState, ProcessKind, RunDescription, realtime, rig};

use crate::outcome::{Outcome, remark, say};
use crate::until_ci::{Share, StopRule, estimate_of};
use crate::{large_job, offline_run};
use child::Child;
pub(crate) use child::{bare_program, program, program_path};
use consumers::Consumers;
pub(crate) use interrupt::Interrupt;
use loop_link::LoopLink;
pub(crate) use loop_link::unsent;
use progress::Progress;
pub(crate) use progress::Shown;
use run_end::fault_words;
pub(crate) use run_end::{EndedInFault, RunEnd};

/// Longest wait for the loop to be ready, beside the time that its rig may take to come up.
const LOOP_READY: Duration = Duration::from_secs(10);
/// Longest wait for the recorder to be ready; the history bridges a longer one.
const RECORDER_READY: Duration = Duration::from_secs(3);
/// Longest wait for the recorder to close its archive after the run, …
const RECORDER_DONE: Duration = Duration::from_secs(120);
/// … and how many samples it merges in a second at least, where it was started anew during the run.
const MERGED_PER_S: u64 = 100_000;
/// Silence of the control loop, which reports ten times a second, after which it is given up. A stall of the host is
/// shorter; long before this the amplifier's watchdog has taken the torque away.
const LOOP_HUNG: Duration = Duration::from_secs(10);
/// Longest wait for the loop to take the torque down and end.
const LOOP_ENDS: Duration = Duration::from_secs(3);
/// Exit statuses after which the loop itself has printed why it cannot run: an error, and wrong usage.
const SAID_WHY: [i32; 2] = [1, 2];
const SEE_DOCTOR: &str = "; run `haptic-camera doctor`";
/// Age from which on a control loop holds its rig …
const HOLDS_RIG: Duration = Duration::from_millis(100);
/// … and from which on its services are there.
const SERVICES_THERE: Duration = Duration::from_secs(3);
/// Time between two looks at the run.
const CYCLE: Duration = Duration::from_millis(20);

/// What a run needs, whichever command it is made for.
pub(crate) struct SupervisedRun {
    /// What is done, in words: "capturing knob 3 …".
    pub(crate) in_words: String,
    pub(crate) request: RunRequest,
    /// Whether the simulated rig is run as fast as the processor goes, without other processes.
    pub(crate) offline: bool,
    /// The viewer's argument; `None` without a live view.
    pub(crate) viewer: Option<&'static str>,
    pub(crate) archive: PathBuf,
    /// Ends the run once every parameter is known within this share.
    pub(crate) until: Option<Share>,
    /// What the operator sees while it goes on.
    pub(crate) shown: Shown,
}

pub(crate) fn claim_archive(out: &Path, knob: &str, before: &str) -> anyhow::Result<Claim> {
    std::fs::create_dir_all(out)
        .with_context(|| format!("the folder {} cannot be made; choose another with --out", out.display()))?;
    Ok(Claim::take(out, &archive_stem(knob, before)))
}

/// What an archive is called: a name that sorts by time, the operator's, and says what was on the rig, a knob's number or file.
pub(crate) fn archive_stem(knob: &str, before: &str) -> String {
    let file = Path::new(knob).file_name().unwrap_or_default().to_string_lossy();
    // A name such as `v1.5` has no ending.
    let name = file.strip_suffix(".toml").unwrap_or(&file);
    let knob: String = name.chars().map(|letter| if letter.is_alphanumeric() { letter } else { '-' }).collect();
    let knob = if knob.parse::<u32>().is_ok() { format!("knob-{knob}") } else { knob };
    let time = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S");
    format!("{time}-{before}{knob}")
}

impl SupervisedRun {
    /// A run to its planned end without a live view, which shows how far it is.
    pub(crate) fn new(in_words: String, request: RunRequest, archive: PathBuf, offline: bool) -> Self {
        Self { in_words, request, offline, viewer: None, archive, until: None, shown: Shown::Time }
    }

    /// Makes the run and its archive; [`LoopSaidWhy`] when the control loop cannot run.
    pub(crate) fn take(&self, interrupt: &Interrupt) -> anyhow::Result<RunEnd> {
        interrupt.noted_during(|interrupted| self.take_until(interrupted))
    }

    fn take_until(&self, interrupted: &AtomicBool) -> anyhow::Result<RunEnd> {
        if self.offline {
            say(format!("{}, offline", self.in_words));
            return offline_run::archive(&self.request, &self.archive, interrupted, self.until);
        }
        if !self.request.is_open_ended() {
            large_job::tell(self.request.ticks());
        }
        let request = toml::to_string(&self.request).context("the request for this run cannot be encoded")?;
        let mut control_loop = Child::start(program("rt-loop")?.arg(format!("--request={request}")))?;
        let mut end = self.supervise(&mut control_loop, interrupted);
        // However the run went: the torque is ramped down, the loop ends, nothing stays behind.
        control_loop.end(LOOP_ENDS);
        clear_shared_memory();
        if let Ok(end) = &mut end
            && !end.loop_failed
            && control_loop.exit_code() != Some(0)
        {
            end.loop_failed = true;
            say_why_unless_said(&mut control_loop, "the control loop ended with an error", &driving(&end.run));
        }
        end
    }

    /// Makes a run and requires that it comes to its planned end; gives its archive and whether data was lost.
    pub(crate) fn complete(&self, interrupt: &Interrupt) -> anyhow::Result<(PathBuf, Outcome)> {
        let Self { in_words, archive, .. } = self;
        let end = self.take(interrupt)?;
        let folder = archive.parent().unwrap_or(archive).display();
        anyhow::ensure!(!end.interrupted, "stopped by the operator; what was captured so far is in {folder}");
        if let Some(words) = fault_words(&end.run, &end.status) {
            return Err(EndedInFault { run: in_words.clone(), words, fault: Fault::from_code(end.status.fault) }.into());
        }
        let archive = end.left_archive(archive).with_context(|| format!("{in_words}: no archive was left"))?;
        let outcome = end.settle(&Overview::read(&archive)?);
        anyhow::ensure!(outcome != Outcome::Failed, "{in_words}: did not finish");
        Ok((archive, outcome))
    }

    /// From the loop's start to the archive's end.
    fn supervise(&self, control_loop: &mut Child, interrupted: &AtomicBool) -> anyhow::Result<RunEnd> {
        let mut link = wait_for_loop(control_loop, interrupted)?.ok_or(LoopSaidWhy)?;
        let mut consumers = Consumers::start(&self.archive, self.viewer, self.until, link.status.core)?;
        let ready_by = Instant::now() + RECORDER_READY;
        while link.health_of(ProcessKind::Recorder).is_none() && Instant::now() < ready_by {
            std::thread::sleep(CYCLE);
            link.listen();
            consumers.revive(&link);
        }
        say(format!("{}, core {}", self.in_words, link.status.core));
        if link.status.realtime & realtime::FULL != realtime::FULL {
            remark("without full real-time permission: ticks may be late, and the capture records that");
        }

        if let Err(error) = link.request(CommandKind::Start) {
            let had_ended = control_loop.has_ended();
            control_loop.end(LOOP_ENDS);
            consumers.end();
            if had_ended {
                say_why_unless_said(control_loop, "the control loop ended before the run began", SEE_DOCTOR);
                return Err(LoopSaidWhy.into());
            }
            return Err(error);
        }
        let mut rule = self.until.map(StopRule::new);
        let mut progress = Progress::new(self);
        let (mut stopped_by_operator, mut loop_failed) = (false, false);
        let fault = FaultInjection::listen(fault_injection::SERVING_THREAD)?;
        loop {
            std::thread::sleep(CYCLE);
            if let Some(fault) = &fault {
                fault.panic_if_requested();
            }
            let has_ended = control_loop.has_ended();
            link.listen();
            control_loop.hear(link.status.monotonic_time_ns);
            if link.status.finished == 1 {
                break;
            }
            if has_ended {
                remark(format!(
                    "the control loop ended in the middle of the run ({}){}; what was recorded so far is kept",
                    control_loop.end_in_words(),
                    driving(&link.run)
                ));
                loop_failed = true;
                break;
            }
            consumers.revive(&link);
            progress.show(&link);
            if !stopped_by_operator {
                stopped_by_operator = interrupted.load(Ordering::Acquire);
                // The loop takes the torque down and ends; by force if it does not answer.
                if (is_enough_known(rule.as_mut(), &link) || stopped_by_operator)
                    && let Err(error) = link.request(CommandKind::Stop)
                {
                    remark(format!("{error:#}"));
                    control_loop.end(LOOP_ENDS);
                }
            }
            if control_loop.silence() > LOOP_HUNG {
                remark("the control loop does not respond and is killed");
                control_loop.end(LOOP_ENDS);
            }
        }
        drop(progress);
        let merging = Duration::from_secs(link.status.taken_samples() / MERGED_PER_S);
        let recorder_exit = consumers.finish_recorder(RECORDER_DONE + merging, || {
            link.listen();
            !control_loop.has_ended()
        });
        let restarts = consumers.end();
        let LoopLink { status, run, models, .. } = link;
        let (interrupted, achieved) = (stopped_by_operator, rule);
        Ok(RunEnd { status, recorder_exit, restarts, run, models, interrupted, achieved, loop_failed })
    }
}

/// Whether the live fitter's newest word ends a run that goes on until enough is known; true once at most.
fn is_enough_known(rule: Option<&mut StopRule>, link: &LoopLink) -> bool {
    let Some((rule, fit)) = rule.filter(|rule| rule.ended_s.is_none()).zip(link.fit()) else { return false };
    let time_s = fit.latest_tick as f64 / link.status.rate_hz.max(1.0);
    rule.take(time_s, estimate_of(fit))
}

pub(crate) fn clear_shared_memory() {
    if files_in_shared_memory(&rig::runtime_dir()).is_empty() {
        return;
    }
    match shared_types::clean_up::clear_shared_memory() {
        Ok(0) => {}
        // Whoever still follows the rig needs them, and takes them away at its end.
        Ok(left) => tracing::info!("{left} files stay in shared memory while another program follows this rig"),
        Err(error) => remark(error),
    }
}

/// Which rig the loop drove when it ended: what crashed may be the rig's library.
fn driving(run: &RunDescription) -> String {
    format!(", driving the rig '{}'", run.apparatus)
}

/// Says how a loop ended that has not said so itself, and what to do next.
fn say_why_unless_said(control_loop: &mut Child, what: &str, next: &str) {
    if control_loop.exit_code().is_none_or(|code| !SAID_WHY.contains(&code)) {
        remark(format!("{what} ({}){next}", control_loop.end_in_words()));
    }
}

/// The control loop did not run, and has printed why.
#[derive(Debug, thiserror::Error)]
#[error("the control loop could not run")]
pub(crate) struct LoopSaidWhy;

/// Waits until the loop is armed; `None` when it ended first, having said why.
fn wait_for_loop(control_loop: &mut Child, interrupted: &AtomicBool) -> anyhow::Result<Option<LoopLink>> {
    let wait = LOOP_READY + Duration::from_secs_f64(LONGEST_PREPARATION_S);
    let deadline = Instant::now() + wait;
    let mut link: Option<LoopLink> = None;
    loop {
        if control_loop.has_ended() {
            say_why_unless_said(control_loop, "the control loop ended before it was ready", SEE_DOCTOR);
            return Ok(None);
        }
        if let Some(open) = &mut link {
            open.listen();
            match LoopState::from_code(open.status.state) {
                Some(LoopState::Armed) => return Ok(link),
                // The description comes a little after the status.
                Some(LoopState::Fault) if !open.run.apparatus.is_empty() || Instant::now() >= deadline => {
                    let fault = fault_words(&open.run, &open.status).unwrap_or_default();
                    remark(format!("the run did not begin: {fault}"));
                    return Ok(None);
                }
                _ => {}
            }
        } else if control_loop.age() > HOLDS_RIG {
            // The services belong to this loop only once it holds the rig.
            match LoopLink::open(control_loop.id()) {
                // The loop may be making them just now.
                Err(error) if control_loop.age() > SERVICES_THERE => return Err(error),
                opened => link = opened.ok(),
            }
        }
        anyhow::ensure!(!interrupted.load(Ordering::Acquire), "stopped before the run began");
        anyhow::ensure!(
            Instant::now() < deadline,
            "the control loop was not ready within {} s; run `haptic-camera doctor`",
            wait.as_secs()
        );
        std::thread::sleep(CYCLE);
    }
}
