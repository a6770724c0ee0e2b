//! The options of what runs the control loop under supervision.

use std::path::PathBuf;

use clap::Args;
use rt_loop::motor_cogging::MotorCogging;

/// Options of what runs the control loop under supervision.
#[derive(Clone, Debug, Args)]
pub struct RunOptions {
    /// The rig: `sim` is the simulated one
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// The rig's calibration, instead of the one that it comes with
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub calibration: Option<PathBuf>,
    /// Samples per second
    #[arg(long, default_value_t = 10_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// Folder for the archive, and for the model and the report that are made of a capture
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub out: PathBuf,
    /// Seed of the simulated rig's noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Cogging of the simulated rig's motor, as periods per turn, mNm and rad; may be repeated
    #[arg(long, value_name = "PER_TURN:MNM[:RAD]")]
    pub motor_cogging: Vec<MotorCogging>,
    /// Core for the real-time thread [default: the last one]
    #[arg(long)]
    pub core: Option<usize>,
    /// Do without the live view
    #[arg(long)]
    pub no_viewer: bool,
    /// Show the live view in a window of its own instead of a web page
    #[arg(long, conflicts_with = "no_viewer")]
    pub native_viewer: bool,
    /// Run the simulated rig as fast as the processor goes, without the real-time processes
    #[arg(long)]
    pub offline: bool,
}

impl RunOptions {
    /// The control loop's part of them.
    #[must_use]
    pub fn loop_arguments(&self) -> Vec<String> {
        let mut arguments = vec![
            format!("--apparatus={}", self.apparatus),
            format!("--rate-hz={}", self.rate_hz),
            format!("--seed={}", self.seed),
        ];
        if let Some(calibration) = &self.calibration {
            arguments.push(format!("--calibration={}", calibration.display()));
        }
        arguments.extend(self.motor_cogging.iter().map(|harmonic| format!("--motor-cogging={harmonic}")));
        if let Some(core) = self.core {
            arguments.push(format!("--core={core}"));
        }
        arguments
    }
}
