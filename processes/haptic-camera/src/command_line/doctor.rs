//! The options of `doctor`.

use std::path::PathBuf;

use clap::Args;

/// Options of `doctor`.
#[derive(Debug, Args)]
pub struct DoctorOptions {
    /// Also check whether this rig's driver is available
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
}
