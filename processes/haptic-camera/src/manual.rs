//! `completions` and `man`: the completions for a shell and the manual pages of this program.

use std::path::Path;

use anyhow::Context as _;
use clap::CommandFactory as _;
use clap_complete::Shell;

use crate::command_line::Command;
use crate::command_line::outputs::{kind, write};
use crate::outcome::say;

pub fn completions(shell: Shell) -> anyhow::Result<()> {
    let mut command = Command::command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut command, name, &mut script);
    say(String::from_utf8_lossy(&script).trim_end());
    Ok(())
}

/// Writes a manual page for the program and one for each command.
pub fn pages(folder: &Path) -> anyhow::Result<()> {
    let refused = || format!("the manual pages cannot be written to {}; choose another folder", folder.display());
    let made = tempfile::tempdir()?;
    clap_mangen::generate_to(Command::command(), &made)?;
    std::fs::create_dir_all(folder).with_context(refused)?;
    for page in std::fs::read_dir(&made)? {
        let page = page?;
        let text = std::fs::read_to_string(page.path())?;
        write(&folder.join(page.file_name()), kind::MANUAL_PAGE, &text).with_context(refused)?;
    }
    say(format!("the manual pages are in {}; `man {0}/haptic-camera.1` shows the first", folder.display()));
    Ok(())
}
