//! How a command ended, as an exit status.

use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};

use indicatif::ProgressBar;

/// The panel that is on the screen: it is taken away while something else is printed, and drawn again below.
static PANEL: Mutex<Option<ProgressBar>> = Mutex::new(None);

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
pub fn tell_error(error: &anyhow::Error) {
    remark(format!("error: {error:#}"));
}

/// Prints a line for the operator on standard output, or several, without the blanks with which tables fill their lines.
///
/// A closed pipe is no reason to fail: whoever reads has seen enough.
pub fn say(lines: impl std::fmt::Display) {
    use std::io::Write as _;
    let lines = lines.to_string();
    let trimmed: Vec<&str> = lines.split('\n').map(str::trim_end).collect();
    beside_panel(|| drop(writeln!(std::io::stdout(), "{}", trimmed.join("\n"))));
}

/// Prints a remark for the operator on standard error, apart from results.
pub fn remark(line: impl std::fmt::Display) {
    use std::io::Write as _;
    beside_panel(|| drop(writeln!(std::io::stderr(), "{line}")));
}

/// Keeps what is printed from now on apart from a panel on the same terminal.
pub fn hold_panel(panel: &ProgressBar) {
    *PANEL.lock().unwrap_or_else(PoisonError::into_inner) = Some(panel.clone());
}

/// The panel is gone.
pub fn release_panel() {
    *PANEL.lock().unwrap_or_else(PoisonError::into_inner) = None;
}

fn beside_panel(print: impl FnOnce()) {
    let panel = PANEL.lock().unwrap_or_else(PoisonError::into_inner).clone();
    match panel {
        Some(panel) => panel.suspend(print),
        None => print(),
    }
}
