//! The options of commands that run the control loop under supervision.

use std::path::PathBuf;

use clap::Args;

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
