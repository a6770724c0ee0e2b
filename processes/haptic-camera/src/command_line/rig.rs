//! The options of what turns the rig without a knob.

use std::path::PathBuf;

use clap::Args;
use rt_loop::motor_cogging::MotorCogging;

/// Options of what turns the rig without a knob.
#[derive(Debug, Args)]
pub struct RigOptions {
    /// The rig: `sim` is the simulated one
    #[arg(long, default_value = "sim")]
    pub apparatus: String,
    /// Run the simulated rig as fast as the processor goes, without the real-time processes
    #[arg(long)]
    pub offline: bool,
    /// Seed of the simulated rig's noise
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Cogging of the simulated rig's motor, as periods per turn, mNm and rad; may be repeated
    #[arg(long, value_name = "PER_TURN:MNM[:RAD]")]
    pub motor_cogging: Vec<MotorCogging>,
    /// Folder for the captures made on the way
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}
