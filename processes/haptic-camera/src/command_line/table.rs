//! The options of `table`.

use std::num::NonZero;
use std::path::PathBuf;

use clap::Args;

/// Options of `table`.
#[derive(Debug, Args)]
pub struct TableOptions {
    /// Folders of captures, searched recursively
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Write the table here
    #[arg(long, value_name = "FILE.parquet")]
    pub out: PathBuf,
    /// Limits, as for `judge`: adds the figures of the sheet and the verdict to every row
    #[arg(long, value_name = "SPEC.toml")]
    pub spec: Option<PathBuf>,
    /// Captures to fit at once [default: one per core]
    #[arg(long, value_name = "N")]
    pub jobs: Option<NonZero<usize>>,
}
