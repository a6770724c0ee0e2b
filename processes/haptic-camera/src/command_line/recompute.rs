//! The options of `recompute`.

use std::path::PathBuf;

use clap::Args;

/// Options of `recompute`.
#[derive(Debug, Args)]
pub struct RecomputeOptions {
    /// The archive of a replay
    #[arg(value_name = "CAPTURE")]
    pub capture: PathBuf,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}
