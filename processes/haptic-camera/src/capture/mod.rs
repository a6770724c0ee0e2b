//! `capture`: the control loop and its consumers, started, watched and ended together.

mod budget;
mod children;
mod evidence;
mod finish;
mod loop_link;
mod next;
mod progress;
mod until_named;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::Context as _;
use shared_types::{CommandKind, Fault, LoopState, LoopStatus, ProcessKind, realtime};

use crate::command_line::CaptureOptions;
use crate::offline_run;
use crate::outcome::{Outcome, remark, say};
pub(crate) use budget::Budget;
pub(crate) use children::program_path;
use children::{Child, Consumers, program};
use loop_link::LoopLink;
use progress::Progress;

/// Longest wait for the loop to be ready.
const LOOP_READY: Duration = Duration::from_secs(10);
/// Longest wait for the recorder to be ready; the history bridges a longer one.
const RECORDER_READY: Duration = Duration::from_secs(3);
/// Longest wait for the recorder to close its archive after the run, not counting long merges.
const RECORDER_DONE: Duration = Duration::from_secs(120);
/// Time between two looks at the run.
const CYCLE: Duration = Duration::from_millis(20);

/// Runs a capture from start to end, or capture after capture until the knob's effects have names.
///
/// # Errors
/// Whatever keeps a run from being started, recorded or ended.
pub fn run(options: &CaptureOptions) -> anyhow::Result<Outcome> {
    let interrupted = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGINT, Arc::clone(&interrupted))?;
    signal_hook::flag::register(signal_hook::consts::SIGTERM, Arc::clone(&interrupted))?;
    if options.diagnose {
        return until_named::run(options, &interrupted);
    }
    let archive = archive_path(options)?;
    match take(options, &archive, &interrupted)? {
        Some(end) => finish::conclude(&archive, &end),
        None => Ok(Outcome::Failed),
    }
}

/// Makes one run and its archive; `None` when the control loop itself said why it cannot run.
fn take(options: &CaptureOptions, archive: &Path, interrupted: &AtomicBool) -> anyhow::Result<Option<RunEnd>> {
    if options.offline {
        return offline(options, archive, interrupted).map(Some);
    }
    let mut control_loop = Child::start(program("rt-loop")?.args(loop_arguments(options)))?;
    let end = supervise(options, archive, &mut control_loop, interrupted);
    // However the run went: the torque is ramped down, the loop ends, nothing stays behind.
    control_loop.end(Duration::from_secs(3));
    clear_shared_memory();
    end
}

/// The same without clock and other processes.
fn offline(options: &CaptureOptions, archive: &Path, interrupted: &AtomicBool) -> anyhow::Result<RunEnd> {
    say(format!("capturing {}, offline", in_words(options)));
    let run = offline_run::archive(&loop_arguments(options), archive, interrupted)?;
    Ok(RunEnd {
        status: LoopStatus {
            published_samples: run.samples as u64,
            fault: run.fault.map_or(0, Fault::code),
            finished: 1,
            ..LoopStatus::default()
        },
        recorder_exit: Some(0),
        restarts: Vec::new(),
        interrupted: interrupted.load(Ordering::Acquire),
        loop_died: false,
    })
}

/// Takes away what the run left in shared memory.
fn clear_shared_memory() {
    match shared_types::clean_up::clear_shared_memory() {
        Ok(0) => {}
        // Whoever still follows the rig needs them, and takes them away at its end.
        Ok(left) => tracing::info!("{left} files stay in shared memory while another program follows this rig"),
        Err(error) => remark(error),
    }
}

/// How a run ended.
pub(crate) struct RunEnd {
    /// The loop's last word.
    pub(crate) status: LoopStatus,
    /// Exit code of the recorder that closed the archive.
    pub(crate) recorder_exit: Option<i32>,
    /// Restarts of recorder, live fitter and viewer.
    pub(crate) restarts: Vec<(ProcessKind, u32)>,
    /// Whether the operator ended it early.
    pub(crate) interrupted: bool,
    /// Whether the control loop died before the run had ended.
    pub(crate) loop_died: bool,
}

/// From the loop's start to the archive's end; `None` when the loop itself said why it cannot run.
fn supervise(
    options: &CaptureOptions,
    archive: &Path,
    control_loop: &mut Child,
    interrupted: &AtomicBool,
) -> anyhow::Result<Option<RunEnd>> {
    let Some(mut link) = wait_for_loop(control_loop, interrupted)? else { return Ok(None) };
    let mut consumers = Consumers::start(archive, options)?;
    let ready_by = Instant::now() + RECORDER_READY;
    while !link.has_heard_from(ProcessKind::Recorder) && Instant::now() < ready_by {
        std::thread::sleep(CYCLE);
        link.listen();
        consumers.revive();
    }
    tell_start(options, link.status());

    link.request(CommandKind::Start)?;
    let mut progress = Progress::new(options.duration_s);
    let (mut stopped_by_operator, mut loop_died) = (false, false);
    loop {
        std::thread::sleep(CYCLE);
        link.listen();
        consumers.revive();
        progress.show(&link);
        if interrupted.load(Ordering::Acquire) && !stopped_by_operator {
            stopped_by_operator = true;
            link.request(CommandKind::Stop)?;
        }
        if link.status().finished == 1 {
            break;
        }
        if control_loop.has_ended() {
            progress.close();
            remark("the control loop ended in the middle of the run; what was captured so far is kept");
            loop_died = true;
            break;
        }
    }
    progress.close();
    let recorder_exit = consumers.finish_recorder(RECORDER_DONE, || link.listen());
    let restarts = consumers.end();
    let interrupted = stopped_by_operator;
    Ok(Some(RunEnd { status: *link.status(), recorder_exit, restarts, interrupted, loop_died }))
}

/// Waits until the loop is armed; `None` when it ended first, having said why.
fn wait_for_loop(control_loop: &mut Child, interrupted: &AtomicBool) -> anyhow::Result<Option<LoopLink>> {
    let deadline = Instant::now() + LOOP_READY;
    let mut link: Option<LoopLink> = None;
    loop {
        if control_loop.has_ended() {
            return Ok(None);
        }
        match &mut link {
            // Only once the loop holds the rig are its services its own.
            None if control_loop.age() > Duration::from_millis(100) => link = Some(LoopLink::open(control_loop.id())?),
            None => {}
            Some(open) => {
                open.listen();
                if LoopState::from_code(open.status().state) == Some(LoopState::Armed) {
                    return Ok(link);
                }
            }
        }
        anyhow::ensure!(!interrupted.load(Ordering::Acquire), "stopped before the capture began");
        anyhow::ensure!(
            Instant::now() < deadline,
            "the control loop was not ready within {} s; run `haptic-camera doctor`",
            LOOP_READY.as_secs()
        );
        std::thread::sleep(CYCLE);
    }
}

fn tell_start(options: &CaptureOptions, status: &LoopStatus) {
    say(format!("capturing {}, core {}", in_words(options), status.core));
    if status.realtime & realtime::FULL != realtime::FULL {
        remark("without full real-time permission: ticks may be late, and the capture is marked so");
    }
}

/// What is captured, and how.
fn in_words(options: &CaptureOptions) -> String {
    let amplitude = options.amplitude.map_or_else(String::new, |amplitude| {
        format!(" of {amplitude:.3} {}", if options.torque { "mNm" } else { "rad" })
    });
    let CaptureOptions { knob, sweep, rate_hz, duration_s, .. } = options;
    format!("knob {knob} with {sweep}{amplitude} at {rate_hz} Hz for {duration_s} s")
}

/// Where the archive goes: a name that sorts by time and says which knob.
fn archive_path(options: &CaptureOptions) -> anyhow::Result<PathBuf> {
    std::fs::create_dir_all(&options.out)
        .with_context(|| format!("the folder {} cannot be made; choose another with --out", options.out.display()))?;
    let knob = Path::new(&options.knob).file_stem().map_or_else(String::new, |stem| {
        stem.to_string_lossy().chars().map(|letter| if letter.is_alphanumeric() { letter } else { '-' }).collect()
    });
    let knob = if knob.parse::<u32>().is_ok() { format!("knob-{knob}") } else { knob };
    let time = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S");
    let free = (1..).map(|number| match number {
        1 => options.out.join(format!("{time}-{knob}.mcap")),
        _ => options.out.join(format!("{time}-{knob}-{number}.mcap")),
    });
    free.into_iter().find(|path| !path.exists()).context("no free name for the archive")
}

fn loop_arguments(options: &CaptureOptions) -> Vec<String> {
    let mut arguments = vec![
        format!("--apparatus={}", options.apparatus),
        format!("--knob={}", options.knob),
        format!("--sweep={}", options.sweep),
        format!("--rate-hz={}", options.rate_hz),
        format!("--duration-s={}", options.duration_s),
        format!("--seed={}", options.seed),
    ];
    if options.torque {
        arguments.push("--torque".to_owned());
    }
    if let Some(amplitude) = options.amplitude {
        arguments.push(format!("--amplitude={amplitude}"));
    }
    if let Some(calibration) = &options.calibration {
        arguments.push(format!("--calibration={}", calibration.display()));
    }
    if let Some(core) = options.core {
        arguments.push(format!("--core={core}"));
    }
    arguments
}

/// The fault that ended a run, in words.
pub(crate) fn fault_words(status: &LoopStatus) -> Option<String> {
    Fault::from_code(status.fault).map(|fault| fault.to_string())
}
