//! A run of the simulated rig as fast as the processor goes: the control step without clock or other processes.

use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context as _;
use archive::Capture;
use clap::Parser as _;
use rt_loop::control::{ControlState, Reading, Request};
use rt_loop::plan::{Options, Plan};
use shared_types::{Fault, LoopState, Sample};

/// Time for which the rig is armed before the run begins, s.
const ARMED_S: f64 = 0.3;

/// How an offline run went.
#[derive(Clone, Copy, Debug)]
pub struct OfflineRun {
    /// Samples that were taken.
    pub samples: usize,
    /// Why it ended early, if a limit was passed.
    pub fault: Option<Fault>,
}

/// Makes the run that the control loop's `arguments` ask for, and keeps its archive at `path`.
///
/// Once `stop` is set the torque is ramped down as in a live run, and the archive ends there.
///
/// # Errors
/// What keeps the run from being made, and an archive that cannot be written.
pub fn archive(arguments: &[String], path: &Path, stop: &AtomicBool) -> anyhow::Result<OfflineRun> {
    let plan = Plan::new(&Options::try_parse_from([&["rt-loop".to_owned()], arguments].concat())?)?;
    let rate_hz = plan.control.rate_hz;
    let mut description = plan.description()?;
    description.notes.push(("time".to_owned(), "offline: the plant's, not a clock's".to_owned()));
    let (samples, fault) = samples_of(plan, stop)?;
    let column = |of: fn(&Sample) -> f64| samples.iter().map(of).collect::<Vec<f64>>();
    let capture = Capture {
        velocity_rad_s: Some(column(|sample| sample.velocity_rad_s)),
        acceleration_rad_s2: Some(column(|sample| sample.acceleration_rad_s2)),
        commanded_angle_rad: Some(column(|sample| sample.commanded_angle_rad)),
        commanded_torque_mnm: Some(column(|sample| sample.commanded_torque_mnm)),
        description: Some(description),
        ..Capture::from_columns(rate_hz, column(|sample| sample.angle_rad), column(|sample| sample.torque_mnm))
    };
    capture.write_mcap(path)?;
    Ok(OfflineRun { samples: samples.len(), fault })
}

/// Every sample of a run, tick by tick.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "ticks of a run of minutes"
)]
fn samples_of(plan: Plan, stop: &AtomicBool) -> anyhow::Result<(Vec<Sample>, Option<Fault>)> {
    let Plan { mut apparatus, rig, control, rendering, .. } = plan;
    let state = ControlState::new(control, &rig.calibration).context("the rate is too low for the filters")?;
    let mut state = match rendering {
        Some(rendering) => state.with_renderer(rendering.renderer),
        None => state,
    };
    apparatus.enable()?;
    state.arm();
    let start = (ARMED_S * control.rate_hz) as u64;
    let mut samples = Vec::new();
    for tick in 0.. {
        if tick == start {
            state.request(Request::Start);
        }
        if stop.load(Ordering::Acquire) {
            state.request(Request::Stop);
        }
        let measurement = apparatus.read((tick as f64 * 1e9 / control.rate_hz).round() as u64);
        let output = state.step(&Reading { elapsed_ticks: 1, measurement });
        let _ = apparatus.write_torque(output.torque_mnm);
        samples.extend(output.sample);
        match state.state() {
            LoopState::Armed | LoopState::Running | LoopState::Stopping => {}
            LoopState::Idle | LoopState::Fault => break,
        }
    }
    apparatus.disable();
    Ok((samples, state.fault()))
}
