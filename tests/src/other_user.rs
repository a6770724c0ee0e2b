//! Another user of the machine: nobody, who has no group of ours.
#![allow(clippy::print_stderr, reason = "a skipped test says so")]

use std::path::Path;
use std::process::Command;

/// A program run by that user.
#[must_use]
pub fn as_nobody(program: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new("setpriv");
    command.args(["--reuid=65534", "--regid=65534", "--clear-groups", "--"]).arg(program).args(arguments);
    command
}

/// Whether there can be another user here; says so if not.
#[must_use]
pub fn there_is_nobody() -> bool {
    let able = as_nobody(Path::new("true"), &[]).output().is_ok_and(|output| output.status.success());
    if !able {
        eprintln!("SKIPPED: only root can try what another user may do (setpriv refused)");
    }
    !able
}
