//! A run from its request to its end: parse, take the rig, start the loop, publish, stop.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use hal::{Apparatus, ApparatusError, RigDescription};
use operator::{LevelFilter, remark};
use shared_types::RunDescription;
use shared_types::fault_injection::{self, FaultInjection};
use shared_types::lease::Lease;
use shared_types::rig::TIMINGS_VARIABLE;

use crate::control::ControlState;
use crate::panicking_apparatus::PanickingApparatus;
use crate::plan::Plan;
use crate::publisher::StreamPublisher;
use crate::realtime::{
    CallWatch, DeclaredCallsMade, Permission, SharedState, TickLog, TickLoop, WATCH_CALLS_VARIABLE, WakefulProcessors,
    block_signals, call_numbers, keep_off_core, prefer_publisher,
};
use crate::request::{Options, RunRequest};
use crate::rig_lock::{DeviceLock, RigLock};
use crate::rigs::Registry;

/// Longest time that a rig may take to come up, s.
pub const LONGEST_PREPARATION_S: f64 = 60.0;
/// Time after which the operator learns that a rig is still coming up.
const TAKES_LONG: Duration = Duration::from_secs(2);
/// Longest time for a rig to abort its preparation, and to switch off.
const GIVES_UP: Duration = Duration::from_secs(2);

/// Runs the real-time process with these drivers. A program for other rigs calls this and nothing else:
///
/// ```no_run
/// # use rt_loop::rigs::RigKind;
/// # static MINE: RigKind =
/// #     RigKind { name: "mine", description: "", template: "", make: |_, _| unimplemented!(), scan: None };
/// fn main() -> std::process::ExitCode {
///     rt_loop::program(&[&MINE])
/// }
/// ```
#[must_use]
pub fn program(registry: Registry<'_>) -> ExitCode {
    shared_types::rig::keep_files_private();
    operator::start_log(LevelFilter::ERROR);
    let options = match operator::parse::<Options>() {
        Ok(options) => options,
        Err(status) => return status,
    };
    if options.drivers {
        return list_drivers(registry);
    }
    match run(&RunRequest::from(options), registry) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::debug!("{error:?}");
            operator::tell_error(&error);
            ExitCode::FAILURE
        }
    }
}

/// Prints the drivers, one a line, as name and description with a tab between.
fn list_drivers(registry: Registry<'_>) -> ExitCode {
    use std::io::Write as _;
    let lines: String = registry.iter().map(|kind| format!("{}\t{}\n", kind.name, kind.description)).collect();
    match std::io::stdout().write_all(lines.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => operator::tell_lost_output(&error),
    }
}

/// Makes a run from its preparation to its end, on a rig of one of these drivers.
///
/// # Errors
/// Whatever keeps the run from being made, in a sentence.
pub fn run(request: &RunRequest, registry: Registry<'_>) -> anyhow::Result<()> {
    let must_end = must_end()?;
    shared_types::shared_memory::check_room()?;
    let mut plan = Plan::with_drivers(request, registry)?;
    let _lock = RigLock::take()?;
    let device = plan.rig.device.as_ref();
    let _device = device.map(|device| DeviceLock::take(&plan.rig.name, device)).transpose()?;
    let Some(apparatus) = prepare(plan.apparatus, &plan.rig, &must_end)? else { return Ok(()) };
    let RigDescription { watchdog_s, codes, notes, .. } = apparatus.description().clone();
    plan.rig = RigDescription { watchdog_s, codes, notes, ..plan.rig };
    plan.apparatus = apparatus;
    let rig = plan.rig.clone();
    let control =
        ControlState::new(plan.control, &plan.rig.calibration).context("the rate is too low for the filters")?;
    let description = plan.description()?;
    plan.watchdog_remark().iter().chain(&plan.servo_remark).for_each(remark);
    let (control, admission) = match plan.rendering {
        Some(rendering) => {
            rendering.remarks_to_print().for_each(remark);
            (control.with_renderer(rendering.renderer), Some(rendering.admission))
        }
        None => (control, None),
    };
    let apparatus = match FaultInjection::listen(fault_injection::REAL_TIME_THREAD)? {
        Some(fault) => Box::new(PanickingApparatus::new(plan.apparatus, fault)),
        None => plan.apparatus,
    };
    let fault = FaultInjection::listen(fault_injection::SERVING_THREAD)?;
    let (mut tick_loop, port) = TickLoop::new(apparatus, control, plan.control.rate_hz);
    let tick_log = tick_log(&mut tick_loop)?;
    let call_watch = call_watch(&mut tick_loop, &rig)?;
    let shared = Arc::clone(&port.shared);
    let (tell_permission, permission) = mpsc::channel();
    let (start, may_start) = mpsc::channel::<()>();
    let core = plan.core;
    let thread = std::thread::Builder::new().name("real-time".to_owned()).spawn(move || {
        block_signals();
        let _ = tell_permission.send(Permission::acquire(core));
        // Until the stream is open; if it cannot be opened the amplifier stays off.
        if may_start.recv().is_err() {
            return Ok(());
        }
        tick_loop.run()
    })?;
    let real_time = RealTimeThread { shared, start: Some(start), thread: Some(thread) };
    let permission = permission.recv().context("the real-time thread ended before it began")?;
    keep_off_core(core);
    prefer_publisher();
    let _wakeful = WakefulProcessors::request();
    if let Some(refused) = permission.refused() {
        tracing::warn!("running without {refused}: ticks may be late, and the capture says so");
    }
    let description = RunDescription { realtime: permission.granted, ..description };
    let mut publisher = StreamPublisher::new(port, &description, permission.core, admission)?;
    if let Some(tick_log) = tick_log {
        publisher.log_ticks(tick_log);
    }
    // Moved behind the publisher, so that it is dropped first: if serving panics, the amplifier is off before shared memory is given back.
    let mut real_time = real_time;
    if must_end() {
        return Ok(());
    }
    real_time.start()?;
    let served = publisher.serve(must_end, || {
        if let Some(fault) = &fault {
            fault.panic_if_requested();
        }
        real_time.is_running()
    });
    if served.is_err() || !real_time.ends_within(GIVES_UP) {
        // Its thread cannot be ended but with the process; what it drives goes torque-free by its watchdog.
        let watchdog = rig.watchdog_s.map_or_else(
            || "no watchdog is known that removes the torque: switch the amplifier off".to_owned(),
            |watchdog_s| format!("its watchdog removes the torque within {watchdog_s} s"),
        );
        drop(publisher);
        remark(format!(
            "error: the rig '{}' does not return from a call; {watchdog}; check its cable, and that its driver never blocks",
            rig.name
        ));
        std::process::exit(1);
    }
    real_time.join().map_err(|error| match error.downcast_ref::<ApparatusError>() {
        Some(error) => anyhow::anyhow!("the amplifier could not be enabled: {}", rig.explain(*error)),
        None => error,
    })?;
    if let Some(tick_log) = publisher.into_tick_log() {
        tick_log.finish().context("the timings cannot be written")?;
    }
    if let Some(call_watch) = call_watch {
        let DeclaredCallsMade { total, most_in_a_tick } = call_watch.finish()?;
        remark(match total {
            0 => "the real-time thread made no system call but its sleep".to_owned(),
            _ => format!(
                "the real-time thread made no system call but its sleep and {total} that the rig declares, at most \
                 {most_in_a_tick} in a tick"
            ),
        });
    }
    Ok(())
}

/// Brings the rig up, on a thread of its own; `None` when the process is to end first.
///
/// # Errors
/// When it does not come up, or takes too long.
fn prepare(
    mut apparatus: Box<dyn Apparatus>,
    rig: &RigDescription,
    must_end: impl Fn() -> bool,
) -> anyhow::Result<Option<Box<dyn Apparatus>>> {
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    let preparing = std::thread::Builder::new().name("preparation".to_owned()).spawn(move || {
        let prepared = apparatus.prepare(&|| stopped.load(Ordering::Acquire));
        (apparatus, prepared)
    })?;
    let begun = Instant::now();
    let mut stopped_at: Option<Instant> = None;
    let mut is_announced = false;
    while !preparing.is_finished() {
        if !is_announced && begun.elapsed() > TAKES_LONG {
            is_announced = true;
            remark(format!(
                "waiting for the rig '{}' to come up, {LONGEST_PREPARATION_S} s at most; Ctrl-C stops it",
                rig.name
            ));
        }
        let is_late = begun.elapsed().as_secs_f64() > LONGEST_PREPARATION_S;
        if stopped_at.is_none() && (must_end() || is_late) {
            stop.store(true, Ordering::Release);
            stopped_at = Some(Instant::now());
        }
        if stopped_at.is_some_and(|stopped_at| stopped_at.elapsed() > GIVES_UP) {
            // The thread is left to the end of the process.
            anyhow::bail!("the rig '{}' does not return from its preparation after being told to stop", rig.name);
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let (apparatus, prepared) =
        preparing.join().map_err(|_| anyhow::anyhow!("the driver of the rig '{}' panicked", rig.name))?;
    match prepared {
        Ok(()) => Ok(Some(apparatus)),
        Err(_) if must_end() => Ok(None),
        Err(ApparatusError::Stopped) => {
            anyhow::bail!("the rig '{}' did not start within {LONGEST_PREPARATION_S} s; check its supply", rig.name)
        }
        // Only now the driver may know what its codes mean.
        Err(error) => {
            let reason = error.reason(&apparatus.description().codes);
            anyhow::bail!("the rig '{}' did not start: {reason}", rig.name)
        }
    }
}

/// The real-time thread. However this thread ends, by a panic too, that one ends first and switches the amplifier off.
struct RealTimeThread {
    shared: Arc<SharedState>,
    /// Until the loop may begin.
    #[allow(clippy::disallowed_types, reason = "sent to once, before the loop begins, and not by it")]
    start: Option<mpsc::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ApparatusError>>>,
}

impl RealTimeThread {
    /// Lets the loop begin.
    fn start(&mut self) -> anyhow::Result<()> {
        let is_begun = self.start.take().is_some_and(|start| start.send(()).is_ok());
        anyhow::ensure!(is_begun, "the real-time thread ended before it began");
        Ok(())
    }

    fn is_running(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// Has it end; `false` where it has not within this time.
    fn ends_within(&self, patience: Duration) -> bool {
        self.shared.quit();
        let begun = Instant::now();
        while self.is_running() && begun.elapsed() < patience {
            std::thread::sleep(Duration::from_millis(5));
        }
        !self.is_running()
    }

    fn join(mut self) -> anyhow::Result<()> {
        self.end().unwrap_or(Ok(Ok(()))).map_err(|_| anyhow::anyhow!("the real-time thread panicked"))??;
        Ok(())
    }

    fn end(&mut self) -> Option<std::thread::Result<Result<(), ApparatusError>>> {
        self.start = None;
        self.shared.quit();
        self.thread.take().map(JoinHandle::join)
    }
}

impl Drop for RealTimeThread {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

/// Where the timings of ticks go, if somebody wants them.
fn tick_log(tick_loop: &mut TickLoop) -> anyhow::Result<Option<TickLog>> {
    let Some(folder) = std::env::var_os(TIMINGS_VARIABLE) else { return Ok(None) };
    let log = TickLog::create(Path::new(&folder), tick_loop.record_ticks());
    log.map(Some).with_context(|| format!("no timings can be written to {}", folder.display()))
}

/// Watches the loop's system calls, if somebody wants it.
fn call_watch(tick_loop: &mut TickLoop, rig: &RigDescription) -> anyhow::Result<Option<CallWatch>> {
    if std::env::var_os(WATCH_CALLS_VARIABLE).is_none_or(|value| value != "1") {
        return Ok(None);
    }
    let (watch, watched) = CallWatch::start(call_numbers(rig)?)?;
    tick_loop.watch_calls(watched);
    Ok(Some(watch))
}

/// Whether the process is to end: a signal came, or its supervisor is gone or lets go.
fn must_end() -> anyhow::Result<impl Fn() -> bool> {
    let signalled = Arc::new(AtomicBool::new(false));
    for signal in [signal_hook::consts::SIGINT, signal_hook::consts::SIGTERM, signal_hook::consts::SIGHUP] {
        signal_hook::flag::register(signal, Arc::clone(&signalled))?;
    }
    let lease = Lease::of_this_process()?;
    Ok(move || signalled.load(Ordering::Relaxed) || lease.as_ref().is_some_and(Lease::has_ended))
}
