//! The real-time process: parse, take the rig, start the loop, publish, stop.

use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread::JoinHandle;

use anyhow::Context as _;
use hal::ApparatusError;
use operator::{LevelFilter, remark};
use rt_loop::control::ControlState;
use rt_loop::drilled_apparatus::DrilledApparatus;
use rt_loop::plan::Plan;
use rt_loop::publisher::StreamPublisher;
use rt_loop::realtime::{
    CallWatch, Permission, SharedState, TickLog, TickLoop, WATCH_CALLS_VARIABLE, WakefulProcessors, block_signals,
    keep_off_core, prefer_publisher,
};
use rt_loop::request::{Options, RunRequest};
use rt_loop::rig_lock::RigLock;
use shared_types::RunDescription;
use shared_types::drill::{self, Drill};
use shared_types::lease::Lease;
use shared_types::rig::TIMINGS_VARIABLE;

fn main() -> ExitCode {
    shared_types::rig::keep_files_private();
    operator::start_log(LevelFilter::ERROR);
    let request = match operator::parse::<Options>() {
        Ok(options) => RunRequest::from(options),
        Err(status) => return status,
    };
    match run(&request) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            tracing::debug!("{error:?}");
            operator::tell_error(&error);
            ExitCode::FAILURE
        }
    }
}

fn run(request: &RunRequest) -> anyhow::Result<()> {
    let must_end = must_end()?;
    shared_types::shared_memory::check_room()?;
    let plan = Plan::new(request)?;
    let _lock = RigLock::take()?;
    let control =
        ControlState::new(plan.control, &plan.rig.calibration).context("the rate is too low for the filters")?;
    let description = plan.description()?;
    let (control, admission) = match plan.rendering {
        Some(rendering) => {
            rendering.told().for_each(remark);
            (control.with_renderer(rendering.renderer), Some(rendering.admission))
        }
        None => (control, None),
    };
    let apparatus = match Drill::listen(drill::REAL_TIME_THREAD)? {
        Some(drill) => Box::new(DrilledApparatus::new(plan.apparatus, drill)),
        None => plan.apparatus,
    };
    let drill = Drill::listen(drill::SERVING_THREAD)?;
    let (mut tick_loop, port) = TickLoop::new(apparatus, control, plan.control.rate_hz);
    let tick_log = tick_log(&mut tick_loop)?;
    let call_watch = call_watch(&mut tick_loop)?;
    let shared = Arc::clone(&port.shared);
    let (tell_permission, permission) = mpsc::channel();
    let (start, may_start) = mpsc::channel::<()>();
    let core = plan.core;
    let real_time = std::thread::Builder::new().name("real-time".to_owned()).spawn(move || {
        block_signals();
        let _ = tell_permission.send(Permission::acquire(core));
        // Until the stream is open; if it cannot be opened the amplifier stays off.
        if may_start.recv().is_err() {
            return Ok(());
        }
        tick_loop.run()
    })?;
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
    if must_end() {
        return Ok(());
    }
    start.send(()).context("the real-time thread ended before it began")?;
    let real_time = RunningLoop { shared, thread: Some(real_time) };
    publisher.serve(must_end, || {
        if let Some(drill) = &drill {
            drill.panic_if_told();
        }
        real_time.is_running()
    });
    real_time.join()?;
    if let Some(tick_log) = publisher.into_tick_log() {
        tick_log.finish().context("the timings cannot be written")?;
    }
    if let Some(call_watch) = call_watch {
        call_watch.finish()?;
        remark("the real-time thread made no system call but its sleep");
    }
    Ok(())
}

/// The real-time thread at work. However this thread ends, by a panic too, the loop ends first and switches the
/// amplifier off.
struct RunningLoop {
    shared: Arc<SharedState>,
    thread: Option<JoinHandle<Result<(), ApparatusError>>>,
}

impl RunningLoop {
    fn is_running(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    fn join(mut self) -> anyhow::Result<()> {
        self.end().unwrap_or(Ok(Ok(()))).map_err(|_| anyhow::anyhow!("the real-time thread panicked"))??;
        Ok(())
    }

    fn end(&mut self) -> Option<std::thread::Result<Result<(), ApparatusError>>> {
        self.shared.quit();
        self.thread.take().map(JoinHandle::join)
    }
}

impl Drop for RunningLoop {
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
fn call_watch(tick_loop: &mut TickLoop) -> anyhow::Result<Option<CallWatch>> {
    if std::env::var_os(WATCH_CALLS_VARIABLE).is_none_or(|value| value != "1") {
        return Ok(None);
    }
    let (watch, watched) = CallWatch::start()?;
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
