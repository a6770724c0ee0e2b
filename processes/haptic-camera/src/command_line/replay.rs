//! The options of `replay`.

use std::path::PathBuf;

use clap::Args;
use rt_loop::request::{HandRequest, LONGEST_DURATION_S, Pace, RenderingRequest, RigRequest, RunRequest};

use crate::command_line::RunOptions;

/// Length of an offline replay, which nobody can stop by hand, s.
const OFFLINE_S: f64 = 10.0;

/// Options of `replay`.
#[derive(Clone, Debug, Args)]
pub struct ReplayOptions {
    /// The model to feel like: a model file, or 1 to 5 for the paper's knobs
    #[arg(value_name = "1…5|MODEL.toml")]
    pub model: String,
    /// The model's name in the archive [default: that of the model]
    #[arg(long)]
    pub name: Option<String>,
    /// Render the nearest model within the rig's limits instead of refusing one that exceeds them, and list the changes
    #[arg(long)]
    pub nearest: bool,
    /// The hand on the simulated rig
    #[command(flatten)]
    pub hand: HandRequest,
    /// Amplitude of the hand's sweep, rad or mm [default: that of the sweep]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Length, s [default: until Ctrl-C, a day at most; offline 10]
    #[arg(long, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// Verify the rendering: capture the rendered knob with simulated hands, fit and diagnose it, and compare it with the
    /// model, parameter by parameter
    #[arg(long, conflicts_with_all = ["hand", "hand_torque", "grip", "amplitude", "duration_s"])]
    pub verify: bool,
    /// Write the comparison as JSON; `-` for standard output
    #[arg(long, requires = "verify", value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the comparison as a report page
    #[arg(long, requires = "verify", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Rate and core
    #[command(flatten)]
    pub pace: Pace,
    /// The rig
    #[command(flatten)]
    pub rig: RigRequest,
    /// Archive and view
    #[command(flatten)]
    pub run: RunOptions,
}

impl ReplayOptions {
    /// The request to the control loop.
    #[must_use]
    pub fn request(&self) -> RunRequest {
        let Self { model, name, nearest, hand, amplitude, duration_s, pace, rig, run, .. } = self;
        let mut request = RunRequest {
            rendering: Some(RenderingRequest { model: model.clone(), nearest: *nearest, without_remarks: false }),
            name: name.clone(),
            amplitude: *amplitude,
            duration_s: duration_s.unwrap_or(if run.offline { OFFLINE_S } else { LONGEST_DURATION_S }),
            pace: pace.clone(),
            rig: rig.clone(),
            ..RunRequest::default()
        };
        request.rig.simulated.hand = Some(hand.clone());
        request
    }
}
