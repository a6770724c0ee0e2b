//! The options of `recover`.

use std::path::PathBuf;

use clap::Args;

/// Options of `recover`.
#[derive(Debug, Args)]
pub struct RecoverOptions {
    /// The truncated or damaged archive, or one that a killed recorder left in parts; it is not changed
    #[arg(value_name = "BROKEN.mcap")]
    pub broken: PathBuf,
    /// Write the recovered archive here
    #[arg(long, value_name = "FIXED.mcap")]
    pub out: PathBuf,
    /// Also keep the samples of a truncated chunk, which no checksum covers
    #[arg(long)]
    pub keep_unchecked: bool,
}
