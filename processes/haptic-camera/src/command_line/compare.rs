//! The options of `compare`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `compare`.
#[derive(Debug, Args)]
pub struct CompareOptions {
    /// What to compare: captures, model files, or 1 to 5 for the paper's knobs; captures of one knob are averaged
    #[arg(required = true, value_name = "CAPTURE|MODEL.toml")]
    pub subjects: Vec<String>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the result as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}
