//! Options that several commands take.

use std::path::PathBuf;

use archive::testers::{Assignments, ColumnChoice};
use clap::Args;
use rt_loop::request::RigRequest;

use crate::outcome::UsageError;

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
        choice.map(Some).map_err(|error| UsageError(anyhow::anyhow!("--columns and --units: {error}")))
    }
}

/// Options of commands that turn the rig without a knob.
#[derive(Debug, Args)]
pub struct RigOptions {
    #[command(flatten)]
    pub request: RigRequest,
    /// Run the simulated rig as fast as the processor can, without the real-time processes
    #[arg(long)]
    pub offline: bool,
    /// Folder for the captures
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}

/// Options of a run and its outputs.
#[derive(Clone, Debug, Args)]
pub struct RunOptions {
    /// Folder for the archive, model and report
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub out: PathBuf,
    /// Run without the live view
    #[arg(long)]
    pub no_viewer: bool,
    /// Show the live view in a window instead of a web page
    #[arg(long, conflicts_with = "no_viewer")]
    pub native_viewer: bool,
    /// Run the simulated rig as fast as the processor can, without the real-time processes
    #[arg(long)]
    pub offline: bool,
}

impl RunOptions {
    /// The viewer's argument; `None` without a live view.
    #[must_use]
    pub fn viewer(&self) -> Option<&'static str> {
        (!self.no_viewer).then_some(if self.native_viewer { "--native" } else { "--web" })
    }
}
