//! The options of `trend`.

use std::path::PathBuf;

use clap::Args;

/// Options of `trend`.
#[derive(Debug, Args)]
pub struct TrendOptions {
    /// A file made by `table`
    #[arg(value_name = "TABLE.parquet")]
    pub table: PathBuf,
    /// How captures are grouped
    #[arg(long, value_enum, default_value = "knob")]
    pub by: TrendGroups,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// How captures are grouped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum TrendGroups {
    /// By knob, to show wear and compare batches.
    Knob,
    /// By rig, to show its drift.
    Rig,
}
