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
use shared_types::{Fault, LoopState, LoopStatus, Sample};

use crate::large_job;
use crate::outcome::remark;
use crate::supervision::RunEnd;
use crate::until_ci::{Share, StopRule};

/// Time for which the rig is armed before the run begins, s.
const ARMED_S: f64 = 0.3;
/// Time between two estimates of the live fit, as in a live run, s.
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
    let models = plan.rendering.iter().map(|rendering| (0, rendering.model.name.clone())).collect();
    plan.rendering.iter().flat_map(Rendering::remarks_to_print).for_each(remark);
    let (planned, rate_hz) = (plan.control.planned_ticks, plan.control.rate_hz);
    large_job::tell(planned);
    if until.is_none() {
        large_job::admit(planned, rate_hz, path)?;
    }
    let mut rule = until.map(StopRule::new);
    let mut fit = until.map(|share| {
        LiveFit::new(rate_hz, plan.rig.calibration.axis, Some(&plan.rig.calibration)).converging_to(share.0)
    });
    let mut next_s = ESTIMATES_S;
    // Fits what is captured as it comes, as the live fitter does.
    let mut is_enough_known = |sample: &Sample| {
        let (Some(fit), Some(rule)) = (&mut fit, &mut rule) else { return false };
        let time_s = sample.time_s(rate_hz);
        fit.push(&LiveSample { time_s, angle_rad: sample.angle_rad, torque_mnm: sample.torque_mnm });
        if time_s < next_s || rule.ended_s.is_some() {
            return false;
        }
        next_s = time_s + ESTIMATES_S;
        rule.take(time_s, fit.estimate())
    };
    let Plan { mut apparatus, rig, control, rendering, .. } = plan;
    let mut state = ControlState::new(control, &rig.calibration).context("the rate is too low for the filters")?;
    if let Some(rendering) = rendering {
        state = state.with_renderer(rendering.renderer);
    }
    apparatus.enable()?;
    state.arm();
    let status = whole_file::write_whole(path, Replace::Nothing, |place| {
        let mut writer = CaptureWriter::new(place, &description)?;
        if let Some(model) = description.first_model() {
            writer.model(&model)?;
        }
        let keep = |sample: &Sample| {
            // The time that its tick would have had.
            let since_start_ns = (sample.time_s(description.rate_hz) * 1e9).round() as u64;
            let monotonic_time_ns = description.clock.monotonic_time_ns.saturating_add(since_start_ns);
            writer.sample(&Sample { monotonic_time_ns, ..*sample })?;
            Ok(is_enough_known(sample))
        };
        let status = turn(apparatus, state, rate_hz, stop, keep)?;
        writer.finish()?;
        Ok(status)
    })?;
    Ok(RunEnd {
        status: LoopStatus { run_id: description.run_id, rate_hz, ..status },
        recorder_exit: Some(0),
        run: description,
        models,
        interrupted: stop.load(Ordering::Acquire),
        achieved: rule,
        ..RunEnd::default()
    })
}

/// Makes the run tick by tick. Every sample goes to `keep` as it comes, so that memory does not grow with the run; the run ends
/// once `keep` returns true.
fn turn(
    mut apparatus: Box<dyn Apparatus>,
    mut state: ControlState,
    rate_hz: f64,
    stop: &AtomicBool,
    mut keep: impl FnMut(&Sample) -> Result<bool, ArchiveError>,
) -> Result<LoopStatus, ArchiveError> {
    let start = (ARMED_S * rate_hz) as u64;
    let mut made = LoopStatus { finished: 1, ..LoopStatus::default() };
    let mut refused = None;
    for tick in 0.. {
        if tick == start {
            state.request(Request::Start);
        }
        if stop.load(Ordering::Acquire) {
            state.request(Request::Stop);
        }
        let measurement = apparatus.exchange((tick as f64 * 1e9 / rate_hz).round() as u64, 0.0);
        let measurement = refused.take().map_or(measurement, Err);
        let output = state.step(&Reading { elapsed_ticks: 1, measurement });
        refused = apparatus.write_torque(output.torque_mnm).err();
        if let Some(sample) = &output.sample {
            made.published_samples += 1;
            made.guarded_ticks += u64::from(sample.flags & Sample::GUARDED != 0);
            if keep(sample)? {
                state.request(Request::Stop);
            }
        }
        if matches!(state.state(), LoopState::Idle | LoopState::Fault) {
            break;
        }
    }
    apparatus.disable();
    made.fault = state.fault().map_or(0, Fault::code);
    Ok(made)
}
