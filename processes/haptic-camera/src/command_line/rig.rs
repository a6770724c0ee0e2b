//! The options of commands that turn the rig without a knob.

use std::path::PathBuf;

use clap::Args;
use rt_loop::request::RigRequest;

/// Options of commands that turn the rig without a knob.
#[derive(Debug, Args)]
pub struct RigOptions {
    /// The rig
    #[command(flatten)]
    pub request: RigRequest,
    /// Run the simulated rig as fast as the processor can, without the real-time processes
    #[arg(long)]
    pub offline: bool,
    /// Folder for the captures
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}
