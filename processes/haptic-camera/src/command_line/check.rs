//! The options of `check`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `check`.
#[derive(Debug, Args)]
pub struct CheckOptions {
    /// Captures to look at: a slow turn for the detents, a creep or a torque ramp for the breakaway
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// The fitted model to check
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}
