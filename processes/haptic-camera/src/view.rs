//! `view`: the live view of the running capture, or a finished one.

use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;

use anyhow::Context as _;
use clap::Args;

use crate::supervision::bare_program;

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

/// Replaces this process by the viewer, which then receives Ctrl-C itself and gives its own exit status.
pub fn run(options: &ViewOptions) -> anyhow::Result<()> {
    let mut command = bare_program("rerun-viewer")?;
    command.arg(if options.native { "--native" } else { "--web" });
    if options.remote {
        command.arg("--remote");
    }
    match &options.capture {
        Some(capture) => command.arg("--capture").arg(capture),
        None => command.arg("--foreground"),
    };
    Err(command.exec()).context("the viewer cannot be started; build the whole workspace")
}
