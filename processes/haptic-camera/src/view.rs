//! `view`: the live view of the running capture, or a finished one.

use std::os::unix::process::CommandExt as _;

use anyhow::Context as _;

use crate::command_line::ViewOptions;
use crate::outcome::Outcome;
use crate::supervision::program_path;

/// Becomes the viewer, which so has the terminal's Ctrl-C to itself and gives its own exit status.
///
/// # Errors
/// When the viewer cannot be started.
pub fn run(options: &ViewOptions) -> anyhow::Result<Outcome> {
    let mut command = std::process::Command::new(program_path("rerun-viewer")?);
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
