//! The options of `view`.

use std::path::PathBuf;

use clap::Args;

/// Options of `view`.
#[derive(Debug, Args)]
pub struct ViewOptions {
    /// A finished capture; without it the running one is followed
    #[arg(value_name = "CAPTURE")]
    pub capture: Option<PathBuf>,
    /// Show it in a window of its own instead of a web page
    #[arg(long)]
    pub native: bool,
    /// Also print the ssh command with which another machine sees the page; nothing is opened to the network
    #[arg(long, conflicts_with = "native")]
    pub remote: bool,
}
