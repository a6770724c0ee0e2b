//! `completions` and `man`: the completions for a shell and the manual pages of this program.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::{Args, CommandFactory as _};

use crate::command_line::CommandLine;
use crate::outcome::say;
use crate::outputs::{kind, write};

#[derive(Debug, Args)]
pub struct CompletionsOptions {
    /// The shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

#[derive(Debug, Args)]
pub struct ManOptions {
    /// The folder for the pages; created if it does not exist
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

/// Prints the completions of a shell on standard output.
pub fn completions(options: &CompletionsOptions) -> anyhow::Result<()> {
    let mut command = CommandLine::command();
    let name = command.get_name().to_owned();
    let mut script = Vec::new();
    clap_complete::generate(options.shell, &mut command, name, &mut script);
    say(String::from_utf8_lossy(&script).trim_end());
    Ok(())
}

/// Writes a manual page for the program and one for each command.
pub fn pages(options: &ManOptions) -> anyhow::Result<()> {
    let folder = &options.folder;
    let refused = || format!("the manual pages cannot be written to {}; choose another folder", folder.display());
    let made = tempfile::tempdir()?;
    clap_mangen::generate_to(CommandLine::command(), &made)?;
    std::fs::create_dir_all(folder).with_context(refused)?;
    for page in std::fs::read_dir(&made)? {
        let page = page?;
        let text = std::fs::read_to_string(page.path())?;
        write(&folder.join(page.file_name()), kind::MANUAL_PAGE, &text).with_context(refused)?;
    }
    say(format!("the manual pages are in {}; `man {0}/haptic-camera.1` shows the first", folder.display()));
    Ok(())
}
