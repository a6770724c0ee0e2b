//! The options of `doctor`.

use std::path::PathBuf;

use clap::Args;

/// Options of `doctor`.
#[derive(Debug, Args)]
pub struct DoctorOptions {
    /// Look also whether this rig's driver can be had
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
}
