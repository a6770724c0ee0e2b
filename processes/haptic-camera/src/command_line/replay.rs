//! The options of `replay`.

use std::path::PathBuf;

use clap::Args;

use crate::command_line::RunOptions;

/// Options of `replay`.
#[derive(Clone, Debug, Args)]
pub struct ReplayOptions {
    /// The model to feel like: a model file, or 1 to 5 for the paper's knobs
    #[arg(value_name = "1…5|MODEL.toml")]
    pub model: String,
    /// Render the nearest that the rig can instead of refusing a model that passes its bounds, and say what was clipped, from what
    /// to what
    #[arg(long)]
    pub nearest: bool,
    /// What the hand on the simulated rig wants: a sweep's name, the angles recorded in a CSV file, or none to let go
    #[arg(long, default_value = "none", value_name = "SWEEP|FILE.csv|none")]
    pub hand: String,
    /// Torque that the hand on the simulated rig applies instead, mNm
    #[arg(long, allow_negative_numbers = true, value_name = "MNM")]
    pub hand_torque: Option<f64>,
    /// Times by which the hand on the simulated rig is stiffer and more damped than a usual pinch grip
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true, value_name = "FACTOR")]
    pub grip: f64,
    /// Largest angle to which the hand's sweep goes, rad [default: as the sweep has it]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Length, s [default: until Ctrl-C, a day at most; offline 10]
    #[arg(long, allow_negative_numbers = true)]
    pub duration_s: Option<f64>,
    /// Prove the rendering: a hand takes the rendered knob through the capture's sweeps, and what is captured is fitted,
    /// diagnosed and compared with the model, parameter by parameter
    #[arg(long, conflicts_with_all = ["hand", "hand_torque", "grip", "amplitude", "duration_s"])]
    pub verify: bool,
    /// Write the comparison as JSON; `-` for standard output
    #[arg(long, requires = "verify", value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the comparison as a report page
    #[arg(long, requires = "verify", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Rig, rate, archive and view
    #[command(flatten)]
    pub run: RunOptions,
}
