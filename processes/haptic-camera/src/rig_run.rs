//! One run of the rig that a command makes by itself, live or offline.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use archive::claim;

use crate::command_line::RigOptions;
use crate::offline_run;
use crate::outcome::say;

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
        let folder = claim::folder(&rig.captures_in, &format!("{time}-{purpose}"))
            .with_context(|| format!("no folder can be made in {}; choose another", rig.captures_in.display()))?;
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
        arguments.extend(rig.motor_cogging.iter().map(|harmonic| format!("--motor-cogging={harmonic}")));
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
        let path = folder.join(format!("{}.mcap", self.knob));
        let run = offline_run::archive(&self.arguments(rig), &path, &AtomicBool::new(false), None)?;
        match run.fault {
            Some(fault) => anyhow::bail!("the run ended in a fault after {} samples: {fault}", run.samples),
            None => Ok(path),
        }
    }
}
