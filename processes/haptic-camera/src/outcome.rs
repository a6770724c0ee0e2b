//! How a command ended, as an exit status.

use std::process::ExitCode;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Done.
    Done,
    /// Failed, and already told.
    Failed,
    /// Wrong usage, and already told.
    WrongUsage,
    /// Done, but data was lost; how much was told.
    DataLost,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(match outcome {
            Outcome::Done => 0,
            Outcome::Failed => 1,
            Outcome::WrongUsage => 2,
            Outcome::DataLost => 3,
        })
    }
}

/// Tells the operator why a command failed, in one line.
#[allow(clippy::print_stderr, reason = "the one place where the program tells its error")]
pub fn tell_error(error: &anyhow::Error) {
    eprintln!("error: {error:#}");
}

/// Prints a line for the operator on standard output.
///
/// A closed pipe is no reason to fail: whoever reads has seen enough.
pub fn say(line: impl std::fmt::Display) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// Prints a remark for the operator on standard error, apart from results.
pub fn remark(line: impl std::fmt::Display) {
    use std::io::Write as _;
    let _ = writeln!(std::io::stderr(), "{line}");
}
