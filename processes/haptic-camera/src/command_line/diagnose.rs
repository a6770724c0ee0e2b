//! The options of `diagnose`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseOptions {
    /// The capture that models are fitted to: an archive, a CSV or an MDF file
    #[arg(value_name = "CAPTURE")]
    pub train: PathBuf,
    /// A held-out capture of the same knob with another motion; without one, sections of the first are held out
    #[arg(long, value_name = "CAPTURE")]
    pub heldout: Option<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// The model to start from [default: inertia, friction and detents, fitted]
    #[arg(long, value_name = "MODEL.toml")]
    pub model: Option<PathBuf>,
    /// Write the diagnosis as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the model with the added effects
    #[arg(long, value_name = "MODEL.toml")]
    pub out: Option<PathBuf>,
    /// Write the report page
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write a rerun file: measured and predicted torque, maps of the residual, each effect with its rivals
    #[arg(long, value_name = "FILE.rrd")]
    pub recording: Option<PathBuf>,
}
