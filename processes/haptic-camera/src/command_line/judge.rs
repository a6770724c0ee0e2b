//! The options of `judge`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `judge`.
#[derive(Debug, Args)]
pub struct JudgeOptions {
    /// Units: for each a capture, a tester's file, or a folder of repeated captures
    #[arg(required = true, value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// Limits on the figures and an envelope for the curve
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: PathBuf,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the verdicts as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}
