//! A run of the simulated rig as fast as the processor goes: the control step without clock or other processes.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use archive::whole_file::{self, Replace};
use archive::{ArchiveError, CaptureWriter};
use hal::Apparatus;
use identification::live::{LiveFit, LiveSample};
use rt_loop::control::{ControlState, Reading, Request};
use rt_loop::plan::{Plan, Rendering};
use rt_loop::request::RunRequest;
use shared_types::{Fault, LoopState, LoopStatus, RunDescription, Sample};

use crate::large_job;
use crate::outcome::remark;
use crate::supervision::{ModelStart, RunEnd};
use crate::until_ci::{Share, StopRule};

/// Time for which the rig is armed before the run begins, s.
const ARMED_S: f64 = 0.3;
/// Time between two estimates of what is known, as in a live run, s.
const ESTIMATES_S: f64 = 0.04;

/// Makes the run asked for, and keeps its archive at `path`.
///
/// Once `stop` is set, or every parameter is known within the share `until`, the torque is ramped down as in a live run,
/// and the archive ends there.
pub fn archive(request: &RunRequest, path: &Path, stop: &AtomicBool, until: Option<Share>) -> anyhow::Result<RunEnd> {
    let plan = Plan::new(request)?;
    anyhow::ensure!(plan.simulated_knob.is_some(), "the {} only runs in real time; omit --offline", plan.rig.name);
    let mut description = plan.description()?;
    description.notes.push(("time".to_owned(), "offline: simulated time".to_owned()));
    let felt = plan.rendering.iter().map(|rendering| ModelStart { tick: 0, name: rendering.model.name.clone() });
    let models = felt.collect();
    plan.rendering.iter().flat_map(Rendering::remarks_to_print).for_each(remark);
    let mut watch = until.map(|share| Watch::new(share, &plan));
    let (planned, rate_hz) = (plan.control.planned_ticks, plan.control.rate_hz);
    large_job::tell(planned);
    if until.is_none() {
        large_job::admit(planned, rate_hz, path)?;
    }
    let armed = armed(plan)?;
    let status = whole_file::write_whole(path, Replace::Nothing, |place| {
        let mut writer = CaptureWriter::new(place, &description)?;
        if let Some(model) = description.first_model() {
            writer.model(&model)?;
        }
        let keep = |sample: &Sample| writer.sample(&dated(sample, &description)).map(drop);
        let status = turn(armed, rate_hz, stop, watch.as_mut(), keep)?;
        writer.finish()?;
        Ok(status)
    })?;
    Ok(RunEnd {
        status: LoopStatus { run_id: description.run_id, rate_hz, ..status },
        recorder_exit: Some(0),
        run: description,
        models,
        interrupted: stop.load(Ordering::Acquire),
        achieved: watch.map(|watch| watch.rule),
        ..RunEnd::default()
    })
}

/// Fits what is captured as it comes, as the live fitter does, and says when enough is known.
struct Watch {
    fit: LiveFit,
    rule: StopRule,
    rate_hz: f64,
    next_s: f64,
}

impl Watch {
    fn new(share: Share, plan: &Plan) -> Self {
        let (rate_hz, calibration) = (plan.control.rate_hz, &plan.rig.calibration);
        Self {
            fit: LiveFit::new(rate_hz, Some(calibration)).converging_to(share.0),
            rule: StopRule::new(share),
            rate_hz,
            next_s: ESTIMATES_S,
        }
    }

    /// Takes a sample; true once the run may end.
    fn take(&mut self, sample: &Sample) -> bool {
        let time_s = sample.time_s(self.rate_hz);
        let (angle_rad, torque_mnm) = (sample.angle_rad, sample.torque_mnm);
        self.fit.push(&LiveSample { time_s, angle_rad, torque_mnm });
        if time_s < self.next_s || self.rule.ended_s.is_some() {
            return false;
        }
        self.next_s = time_s + ESTIMATES_S;
        self.rule.take(time_s, self.fit.estimate())
    }
}

/// The sample with the time that its tick would have had.
fn dated(sample: &Sample, run: &RunDescription) -> Sample {
    let since_start_ns = (sample.time_s(run.rate_hz) * 1e9).round() as u64;
    Sample { monotonic_time_ns: run.clock.monotonic_time_ns.saturating_add(since_start_ns), ..*sample }
}

/// The simulated rig with its amplifier switched on, and the control step that drives it.
fn armed(plan: Plan) -> anyhow::Result<(Box<dyn Apparatus>, ControlState)> {
    let Plan { mut apparatus, rig, control, rendering, .. } = plan;
    let mut state = ControlState::new(control, &rig.calibration).context("the rate is too low for the filters")?;
    if let Some(rendering) = rendering {
        state = state.with_renderer(rendering.renderer);
    }
    apparatus.enable()?;
    state.arm();
    Ok((apparatus, state))
}

/// Makes the run tick by tick; every sample goes to `keep` as it comes, so that memory does not grow with the run.
fn turn(
    (mut apparatus, mut state): (Box<dyn Apparatus>, ControlState),
    rate_hz: f64,
    stop: &AtomicBool,
    mut watch: Option<&mut Watch>,
    mut keep: impl FnMut(&Sample) -> Result<(), ArchiveError>,
) -> Result<LoopStatus, ArchiveError> {
    let start = (ARMED_S * rate_hz) as u64;
    let mut made = LoopStatus { finished: 1, ..LoopStatus::default() };
    for tick in 0.. {
        if tick == start {
            state.request(Request::Start);
        }
        if stop.load(Ordering::Acquire) {
            state.request(Request::Stop);
        }
        let measurement = apparatus.exchange((tick as f64 * 1e9 / rate_hz).round() as u64, 0.0);
        let output = state.step(&Reading { elapsed_ticks: 1, measurement });
        let _ = apparatus.write_torque(output.torque_mnm);
        if let Some(sample) = &output.sample {
            if watch.as_mut().is_some_and(|watch| watch.take(sample)) {
                state.request(Request::Stop);
            }
            made.published_samples += 1;
            made.guarded_ticks += u64::from(sample.flags & Sample::GUARDED != 0);
            keep(sample)?;
        }
        match state.state() {
            LoopState::Armed | LoopState::Running | LoopState::Stopping => {}
            LoopState::Idle | LoopState::Fault => break,
        }
    }
    apparatus.disable();
    made.fault = state.fault().map_or(0, Fault::code);
    Ok(made)
}
