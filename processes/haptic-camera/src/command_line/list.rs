//! The options of `list`.

use std::path::PathBuf;

use clap::Args;

/// Options of `list`.
#[derive(Debug, Args)]
pub struct ListOptions {
    /// The folder to list
    #[arg(default_value = "captures", value_name = "DIR")]
    pub folder: PathBuf,
    /// Write the list as JSON; `-` for standard output
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    pub json: Option<PathBuf>,
}
