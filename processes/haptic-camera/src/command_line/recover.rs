//! The options of `recover`.

use std::path::PathBuf;

use clap::Args;

/// Options of `recover`.
#[derive(Debug, Args)]
pub struct RecoverOptions {
    /// The archive that was cut short or damaged, or that a killed recorder left in parts; it is left as it is
    #[arg(value_name = "BROKEN.mcap")]
    pub broken: PathBuf,
    /// Where the whole archive goes
    #[arg(long, value_name = "FIXED.mcap")]
    pub out: PathBuf,
    /// Also keep the samples of a chunk that was cut off, which no checksum covers
    #[arg(long)]
    pub keep_unchecked: bool,
}
