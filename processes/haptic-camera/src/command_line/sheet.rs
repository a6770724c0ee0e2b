//! The options of `sheet`.

use std::path::PathBuf;

use archive::testers::{Assignments, ColumnChoice};
use clap::Args;

use crate::outputs::UsageError;

/// Options of `sheet`.
#[derive(Debug, Args)]
pub struct SheetOptions {
    /// Captures or testers' files of one part, or a folder of them; several are averaged
    #[arg(required_unless_present = "wall", value_name = "CAPTURE")]
    pub captures: Vec<PathBuf>,
    /// What the columns are
    #[command(flatten)]
    pub table: TableOptions,
    /// Write the sheet as JSON; `-` for standard output
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
    /// Write the figures as a table
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Write the report page
    #[arg(long, requires = "captures", value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Write the paper's five knobs beside SmartKnob's default ones as one page, for the wall
    #[arg(long, value_name = "FILE.html")]
    pub wall: Option<PathBuf>,
}

/// What the columns of a table are that is none of the known ones.
#[derive(Clone, Debug, Args)]
pub struct TableOptions {
    /// The columns of a table, as angle=NAME,torque=NAME or travel=NAME,force=NAME, with time=NAME and contact=NAME (a
    /// voltage that falls) if there are such; a number counts columns from 1
    #[arg(long, value_name = "WHAT=NAME,…")]
    pub columns: Option<Assignments>,
    /// Their units, as angle=deg,torque=Ncm [default: rad, mNm, mm, N, s]
    #[arg(long, value_name = "WHAT=UNIT,…", requires = "columns")]
    pub units: Option<Assignments>,
}

impl TableOptions {
    /// The columns as chosen; `None` where the file's format says.
    ///
    /// # Errors
    /// [`UsageError`] for a choice that cannot be meant.
    pub fn choice(&self) -> Result<Option<ColumnChoice>, UsageError> {
        let Some(columns) = self.columns.clone() else { return Ok(None) };
        let choice = ColumnChoice::new(columns, self.units.clone().unwrap_or_default());
        choice.map(Some).map_err(|error| UsageError::Columns(error.to_string()))
    }
}
