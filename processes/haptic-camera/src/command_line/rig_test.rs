//! The options of `rig-test`.

use std::path::PathBuf;

use clap::Args;

use crate::command_line::RigOptions;

/// Options of `rig-test`.
#[derive(Debug, Args)]
pub struct RigTestOptions {
    /// Interpretation of the paper's sweep: paper (as printed) or linear-chirp
    #[arg(long, default_value = "paper")]
    pub sweep: String,
    /// Samples per second
    #[arg(long, default_value_t = 5_000.0, allow_negative_numbers = true)]
    pub rate_hz: f64,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// How the rig is turned
    #[command(flatten)]
    pub rig: RigOptions,
}
