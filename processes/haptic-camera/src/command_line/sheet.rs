//! The options of `sheet`.

use std::path::PathBuf;

use clap::Args;

use super::columns::ColumnOptions;

/// Options of `sheet`.
#[derive(Debug, Args)]
pub struct SheetOptions {
    /// Captures or testers' files of one part, or a folder of them; several are averaged
    #[arg(required_unless_present = "wall", value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// A capture of the same part at speed, for inertia, viscous friction and breakaway; give it again for further ones
    #[arg(long, requires = "captures", value_name = "CAPTURE")]
    pub dynamic: Vec<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub columns: ColumnOptions,
    /// Write the sheet as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the figures as a table
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write the report page
    #[arg(long, requires = "captures", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write one page with the paper's five knobs and SmartKnob's default ones, for the wall
    #[arg(long, value_name = "FILE.html")]
    pub wall: Option<PathBuf>,
}
