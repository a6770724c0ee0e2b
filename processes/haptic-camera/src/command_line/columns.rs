//! The options that name the columns of a foreign file.

use archive::testers::{Assignments, ColumnChoice};
use clap::Args;

use crate::outputs::UsageError;

/// The columns of a file of unknown format.
#[derive(Clone, Debug, Args)]
pub struct ColumnOptions {
    /// Columns of a table or channels of an MDF file: angle=NAME,torque=NAME or travel=NAME,force=NAME, optionally time=NAME and
    /// contact=NAME (a voltage that falls); a column also by its number from 1, a channel as GROUP/NAME
    #[arg(long, value_name = "WHAT=NAME,…")]
    pub columns: Option<Assignments>,
    /// Units of these columns, as angle=deg,torque=Ncm [default: the file's own, else rad, mNm, mm, N, s]
    #[arg(long, value_name = "WHAT=UNIT,…", requires = "columns")]
    pub units: Option<Assignments>,
}

impl ColumnOptions {
    /// The chosen columns; `None` where the file's format determines them.
    ///
    /// # Errors
    /// [`UsageError`] for an invalid choice.
    pub fn choice(&self) -> Result<Option<ColumnChoice>, UsageError> {
        let Some(columns) = self.columns.clone() else { return Ok(None) };
        let choice = ColumnChoice::new(columns, self.units.clone().unwrap_or_default());
        choice.map(Some).map_err(|error| UsageError::Columns(error.to_string()))
    }
}
