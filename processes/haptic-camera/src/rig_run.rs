//! One run of the rig that a command makes by itself, live or offline.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::Context as _;
use archive::Capture;
use clap::Parser as _;
use rt_loop::control::{ControlState, Reading, Request};
use rt_loop::plan::{Options, Plan};
use shared_types::{LoopState, Sample};

use crate::command_line::RigOptions;
use crate::outcome::say;

/// Time for which the rig is armed before an offline run begins, s.
const ARMED_S: f64 = 0.3;

/// What a run is to be.
#[derive(Clone, Debug)]
pub struct RigRun {
    /// The knob, as `capture --knob` takes it.
    pub knob: &'static str,
    /// The excitation's name.
    pub sweep: String,
    /// Whether a torque is commanded.
    pub torque: bool,
    /// Largest commanded value; `None` for the sweep's own.
    pub amplitude: Option<f64>,
    /// Samples per second.
    pub rate_hz: f64,
    /// Length, s.
    pub duration_s: f64,
    /// The calibration that the run is made with, instead of the rig's own.
    pub calibration: Option<PathBuf>,
}

impl RigRun {
    /// Makes the run and gives its archive.
    ///
    /// # Errors
    /// Whatever keeps the run from being made or recorded, and a fault that ended it.
    pub fn archive(&self, rig: &RigOptions, purpose: &str) -> anyhow::Result<PathBuf> {
        let time = jiff::Zoned::now().strftime("%Y%m%d-%H%M%S");
        let folder = rig.captures_in.join(format!("{time}-{purpose}"));
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("the folder {} cannot be made; choose another", folder.display()))?;
        say(format!(
            "{} with {} for {} s{}",
            match self.knob {
                "none" => "turning the gripper alone",
                "locked" => "loading the locked gripper",
                _ => "turning the knob",
            },
            self.sweep,
            self.duration_s,
            if rig.offline { ", offline" } else { "" }
        ));
        if rig.offline { self.offline(rig, &folder) } else { self.live(rig, &folder) }
    }

    /// The arguments that `capture` and the control loop have in common.
    fn arguments(&self, rig: &RigOptions) -> Vec<String> {
        let mut arguments = vec![
            format!("--apparatus={}", rig.apparatus),
            format!("--knob={}", self.knob),
            format!("--sweep={}", self.sweep),
            format!("--rate-hz={}", self.rate_hz),
            format!("--duration-s={}", self.duration_s),
            format!("--seed={}", rig.seed),
        ];
        if self.torque {
            arguments.push("--torque".to_owned());
        }
        if let Some(amplitude) = self.amplitude {
            arguments.push(format!("--amplitude={amplitude}"));
        }
        if let Some(calibration) = &self.calibration {
            arguments.push(format!("--calibration={}", calibration.display()));
        }
        arguments
    }

    /// Through the real-time processes, as an operator would by `capture`.
    fn live(&self, rig: &RigOptions, folder: &Path) -> anyhow::Result<PathBuf> {
        let program = std::env::current_exe().context("where this program lies is unknown")?;
        let output = Command::new(program)
            .arg("capture")
            .args(self.arguments(rig))
            .arg("--no-viewer")
            .arg(format!("--out={}", folder.display()))
            .stdin(Stdio::null())
            .output()
            .context("the capture cannot be started")?;
        let said = String::from_utf8_lossy(&output.stderr);
        let last = said.trim().lines().last().unwrap_or("it did not say why");
        anyhow::ensure!(output.status.success(), "the capture failed: {}", last.trim_start_matches("error: "));
        let archives = std::fs::read_dir(folder)?.flatten().map(|entry| entry.path());
        archives
            .into_iter()
            .find(|path| path.extension().is_some_and(|extension| extension == "mcap"))
            .with_context(|| format!("the capture left no archive in {}", folder.display()))
    }

    /// The same control step on the simulated rig, as fast as the processor goes.
    fn offline(&self, rig: &RigOptions, folder: &Path) -> anyhow::Result<PathBuf> {
        let mut arguments = self.arguments(rig);
        arguments.insert(0, "rt-loop".to_owned());
        let plan = Plan::new(&Options::try_parse_from(arguments)?)?;
        let mut description = plan.description()?;
        description.notes.push(("time".to_owned(), "offline: the plant's, not a clock's".to_owned()));
        let samples = samples_of(plan)?;
        let column = |of: fn(&Sample) -> f64| samples.iter().map(of).collect::<Vec<f64>>();
        let capture = Capture {
            velocity_rad_s: Some(column(|sample| sample.velocity_rad_s)),
            acceleration_rad_s2: Some(column(|sample| sample.acceleration_rad_s2)),
            commanded_angle_rad: Some(column(|sample| sample.commanded_angle_rad)),
            commanded_torque_mnm: Some(column(|sample| sample.commanded_torque_mnm)),
            description: Some(description),
            ..Capture::from_columns(self.rate_hz, column(|sample| sample.angle_rad), column(|sample| sample.torque_mnm))
        };
        let path = folder.join(format!("{}.mcap", self.knob));
        capture.write_mcap(&path)?;
        Ok(path)
    }
}

/// Every sample of a run, tick by tick.
#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "ticks of a run of minutes"
)]
fn samples_of(plan: Plan) -> anyhow::Result<Vec<Sample>> {
    let Plan { mut apparatus, rig, control, .. } = plan;
    let mut state = ControlState::new(control, &rig.calibration).context("the rate is too low for the filters")?;
    apparatus.enable()?;
    state.arm();
    let start = (ARMED_S * control.rate_hz) as u64;
    let mut samples = Vec::new();
    for tick in 0.. {
        if tick == start {
            state.request(Request::Start);
        }
        let measurement = apparatus.read((tick as f64 * 1e9 / control.rate_hz).round() as u64);
        let output = state.step(&Reading { elapsed_ticks: 1, measurement });
        let _ = apparatus.write_torque(output.torque_mnm);
        samples.extend(output.sample);
        match state.state() {
            LoopState::Armed | LoopState::Running => {}
            _ => break,
        }
    }
    apparatus.disable();
    match state.fault() {
        Some(fault) => anyhow::bail!("the run ended in a fault after {} samples: {fault}", samples.len()),
        None => Ok(samples),
    }
}
