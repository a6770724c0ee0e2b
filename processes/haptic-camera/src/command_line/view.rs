//! The options of `view`.

use std::path::PathBuf;

use clap::Args;

/// Options of `view`.
#[derive(Debug, Args)]
pub struct ViewOptions {
    /// A finished capture [default: the running one]
    #[arg(value_name = "CAPTURE")]
    pub capture: Option<PathBuf>,
    /// Show it in a window instead of a web page
    #[arg(long)]
    pub native: bool,
    /// Also print the ssh command to see the page from another machine; nothing is opened to the network
    #[arg(long, conflicts_with = "native")]
    pub remote: bool,
}
