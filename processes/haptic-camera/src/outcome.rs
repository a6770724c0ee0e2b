//! How a command ended, as an exit status.

use std::io::{Error, Write as _};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use indicatif::ProgressBar;
pub use operator::tell_error;
use operator::visible;

/// The panel that is on the screen: it is taken away while something else is printed, and drawn again below.
static PANEL: Mutex<Option<ProgressBar>> = Mutex::new(None);

/// Whether standard output is for one JSON document alone.
static OUTPUT_IS_JSON: AtomicBool = AtomicBool::new(false);

/// Why standard output no longer takes anything.
static LOST_OUTPUT: OnceLock<Error> = OnceLock::new();

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
    /// Done: a unit is not as its specification says.
    OutOfSpecification,
    /// Done, but of a unit it cannot be told whether it is as its specification says.
    Undecided,
}

impl Outcome {
    /// The worse of two: a failure before lost data.
    #[must_use]
    pub fn worse(self, other: Self) -> Self {
        match (self, other) {
            (Self::Failed, _) | (_, Self::Failed) => Self::Failed,
            (Self::DataLost, _) | (_, Self::DataLost) => Self::DataLost,
            _ => self,
        }
    }

    /// The same, or a failure if standard output did not take all that was printed; told, unless whoever read it has closed it,
    /// as `head` does.
    #[must_use]
    pub fn if_output_was_taken(self) -> Self {
        note_output(std::io::stdout().flush());
        let Some(error) = LOST_OUTPUT.get() else { return self };
        operator::tell_lost_output(error);
        if self == Self::Done { Self::Failed } else { self }
    }
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(match outcome {
            Outcome::Done => 0,
            Outcome::Failed => 1,
            Outcome::WrongUsage => 2,
            Outcome::DataLost => 3,
            Outcome::OutOfSpecification => 4,
            Outcome::Undecided => 5,
        })
    }
}

/// Keeps standard output for the result as JSON: whatever else is said goes to standard error.
pub fn keep_output_for_json() {
    OUTPUT_IS_JSON.store(true, Ordering::Relaxed);
}

/// Whether standard output is kept for the result as JSON.
pub fn is_output_json() -> bool {
    OUTPUT_IS_JSON.load(Ordering::Relaxed)
}

/// Prints a line for the operator on standard output, or several, without the blanks with which tables fill their lines.
///
/// A failure ends nothing here; [`Outcome::if_output_was_taken`] tells it in the end.
pub fn say(lines: impl std::fmt::Display) {
    let lines = lines.to_string();
    let lines = visible(&lines);
    let trimmed = lines.split('\n').map(str::trim_end).collect::<Vec<_>>().join("\n");
    if is_output_json() {
        // A terminal that is gone is no reason to end.
        beside_panel(|| drop(writeln!(std::io::stderr(), "{trimmed}")));
    } else {
        print(&trimmed);
    }
}

/// Prints the result as JSON on standard output.
pub fn print_json(text: &str) {
    print(&visible(text));
}

fn print(text: &str) {
    beside_panel(|| note_output(writeln!(std::io::stdout(), "{text}")));
}

/// Prints a remark for the operator on standard error, in one line apart from results.
pub fn remark(line: impl std::fmt::Display) {
    beside_panel(|| operator::remark(line.to_string()));
}

fn note_output(printed: std::io::Result<()>) {
    if let Err(error) = printed {
        // The first failure is the one that matters.
        let _ = LOST_OUTPUT.set(error);
    }
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
