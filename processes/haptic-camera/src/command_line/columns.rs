//! Which columns of a foreign file are what.

use archive::testers::{Assignments, ColumnChoice};
use clap::Args;

use crate::outputs::UsageError;

/// What the columns of a file are that is none of the known ones.
#[derive(Clone, Debug, Args)]
pub struct ColumnOptions {
    /// Columns of a table or channels of an MDF file: angle=NAME,torque=NAME or travel=NAME,force=NAME, optionally time=NAME and
    /// contact=NAME (a voltage that falls); a column also by its number from 1, a channel as GROUP/NAME
    #[arg(long, value_name = "WHAT=NAME,…")]
    pub columns: Option<Assignments>,
    /// Their units, as angle=deg,torque=Ncm [default: the file's own, else rad, mNm, mm, N, s]
    #[arg(long, value_name = "WHAT=UNIT,…", requires = "columns")]
    pub units: Option<Assignments>,
}

impl ColumnOptions {
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
