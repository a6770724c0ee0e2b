//! The command line: names and options.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

/// Captures how a mechanical knob feels, as numbers.
#[derive(Debug, Parser)]
#[command(name = "haptic-camera", version, about, propagate_version = true)]
#[command(after_help = "Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but data was lost.")]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn a knob through a sweep, watch it live, and keep an archive and a fitted model
    #[command(after_help = "Example:\n  haptic-camera capture --knob 3 --duration-s 10 --out captures")]
    Capture(CaptureOptions),
    /// Fit a model to a capture
    #[command(after_help = "Example:\n  haptic-camera fit captures/20261121-101500-knob-3.mcap --report knob-3.html")]
    Fit(FitOptions),
    /// Simulate a model along a capture's motion or torque
    #[command(after_help = "Example:\n  haptic-camera simulate model.toml --like capture.mcap --out simulated.mcap")]
    Simulate(SimulateOptions),
    /// Open the live view of the running capture, or look at a finished one
    View(ViewOptions),
    /// Make a whole archive of one that was cut short or damaged
    #[command(after_help = "Example:\n  haptic-camera recover broken.mcap --out whole.mcap")]
    Recover(RecoverOptions),
    /// Check what this machine permits: real-time priority, memory, shared memory, programs
    Doctor,
}

/// Options of `capture`.
#[derive(Debug, Args)]
pub struct CaptureOptions {
    /// The rig: `sim` is the simulated one
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// The knob on the simulated rig: 1 to 5 for the paper's, or a model file
    #[arg(long, default_value = "3", value_name = "1…5|FILE.toml")]
    pub knob: String,
    /// The excitation: paper, linear-chirp, multisine, stepped-amplitude or hold
    #[arg(long, default_value = "linear-chirp")]
    pub sweep: String,
    /// Command a torque instead of an angle
    #[arg(long)]
    pub torque: bool,
    /// Largest commanded angle in rad, or torque in mNm [default: 1 rad, 20 mNm]
    #[arg(long, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Samples per second
    #[arg(long, default_value_t = 10_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// Length of the capture, s
    #[arg(long, default_value_t = 10.0, allow_negative_numbers = true)]
    pub duration_s: f64,
    /// Folder for the archive, the model and the report
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub out: PathBuf,
    /// Seed of the simulated rig's noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Core for the real-time thread [default: the last one]
    #[arg(long)]
    pub core: Option<usize>,
    /// Do without the live view
    #[arg(long)]
    pub no_viewer: bool,
    /// Show the live view in a window of its own instead of a web page
    #[arg(long, conflicts_with = "no_viewer")]
    pub native_viewer: bool,
}

/// Options of `fit`.
#[derive(Debug, Args)]
pub struct FitOptions {
    /// The capture: an archive or a CSV file
    #[arg(required = true, value_name = "CAPTURE")]
    pub capture: PathBuf,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the fitted model
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Options of `simulate`.
#[derive(Debug, Args)]
pub struct SimulateOptions {
    /// The model
    #[arg(value_name = "MODEL.toml")]
    pub model: PathBuf,
    /// The capture whose motion or torque is followed
    #[arg(long, value_name = "CAPTURE")]
    pub like: PathBuf,
    /// Where the simulated capture goes: an archive, or CSV if the name ends in .csv
    #[arg(long, value_name = "CAPTURE")]
    pub out: PathBuf,
    /// What is taken from the capture: its motion, giving the torque, or its torque, giving the motion
    #[arg(long, value_enum, default_value = "motion")]
    pub drive: SimulationDrive,
}

/// What a simulation takes from a capture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum SimulationDrive {
    /// The motion: the model's torque is simulated.
    Motion,
    /// The torque: the model's motion is simulated forward.
    Torque,
}

/// Options of `view`.
#[derive(Debug, Args)]
pub struct ViewOptions {
    /// A finished capture; without it the running one is followed
    #[arg(value_name = "CAPTURE")]
    pub capture: Option<PathBuf>,
    /// Show it in a window of its own instead of a web page
    #[arg(long)]
    pub native: bool,
}

/// Options of `recover`.
#[derive(Debug, Args)]
pub struct RecoverOptions {
    /// The archive that was cut short or damaged; it is left as it is
    #[arg(value_name = "BROKEN.mcap")]
    pub broken: PathBuf,
    /// Where the whole archive goes
    #[arg(long, value_name = "FIXED.mcap")]
    pub out: PathBuf,
}
