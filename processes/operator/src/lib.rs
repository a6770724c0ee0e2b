//! What every program says to its operator: an error in one line, and nothing that commands a terminal.
//!
//! Names of files, knobs and models, and whatever a foreign file holds, reach the operator's screen in messages. There a
//! control character would move the cursor or rename the window, and a bidirectional one turn a name around. So everything
//! that is printed passes [`visible`] or [`one_line`] on its way out, and nothing before that needs to know.

mod log;

use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;

pub use foreign_files::{one_line, visible};
pub use log::{log_may_be_coloured, start_log};
pub use tracing_subscriber::filter::LevelFilter;

/// Tells the operator why a program failed, in one line on standard error.
pub fn tell_error(error: &anyhow::Error) {
    remark(format!("error: {error:#}"));
}

/// Tells the operator something in one line on standard error.
pub fn remark(sentence: impl AsRef<str>) {
    print_error(&one_line(sentence.as_ref()));
}

/// Prints a line on standard error; a terminal that is gone is no reason to panic.
fn print_error(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Tells that standard output was not written, unless its reader closed the pipe, as `head` does; gives the exit status of a
/// failure.
pub fn tell_lost_output(error: &std::io::Error) -> ExitCode {
    if error.kind() != ErrorKind::BrokenPipe {
        print_error(&format!("error: standard output could not be written ({error}); free some space, or redirect it"));
    }
    ExitCode::FAILURE
}

/// Parses the command line. Help and version are printed on request, errors in at most three lines.
///
/// # Errors
/// The exit status with which the program is to end.
pub fn parse<Options: clap::Parser>() -> Result<Options, ExitCode> {
    Options::try_parse().map_err(|error| tell_usage(&error))
}

/// Tells what is wrong with a command line: the error, how the command is used, and where to read more, each in one line.
fn tell_usage(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // Help or version, in the colours of the terminal.
        let printed = error.print().and_then(|()| std::io::stdout().flush());
        return printed.map_or_else(|error| tell_lost_output(&error), |()| ExitCode::SUCCESS);
    }
    // The paragraphs of clap's message are: what is wrong, tips, usage, where to read more.
    let text = error.render().to_string();
    let paragraphs: Vec<String> = text.split("\n\n").map(one_line).filter(|line| !line.is_empty()).collect();
    let (usage, errors): (Vec<&String>, Vec<&String>) =
        paragraphs.iter().partition(|line| line.starts_with("Usage:") || line.starts_with("For more"));
    print_error(&errors.into_iter().map(String::as_str).collect::<Vec<_>>().join("; "));
    usage.into_iter().take(2).for_each(|line| print_error(line));
    ExitCode::from(2)
}
