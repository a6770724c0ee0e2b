//! How a command ended, as an exit status.

use std::io::{Error, IsTerminal as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock, PoisonError};

use indicatif::{ProgressBar, WeakProgressBar};
use operator::visible;

use crate::terminal::paragraph;

/// The panel on the screen: hidden while something else is printed, then drawn again below.
static PANEL: Mutex<Option<WeakProgressBar>> = Mutex::new(None);

/// Whether standard output is reserved for the result as JSON; everything else then goes to standard error.
pub static OUTPUT_IS_JSON: AtomicBool = AtomicBool::new(false);

/// The first error of writing to standard output.
static LOST_OUTPUT: OnceLock<Error> = OnceLock::new();

/// How a command ended, with its exit status; what went wrong has been printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Done = 0,
    Failed = 1,
    WrongUsage = 2,
    DataLost = 3,
    /// Done: a unit is out of specification.
    OutOfSpecification = 4,
    /// Done, but the verdict on a unit is undecided.
    Undecided = 5,
}

impl Outcome {
    /// The worse of two: a failure before lost data.
    pub fn worse(self, other: Self) -> Self {
        match (self, other) {
            (Self::Failed, _) | (_, Self::Failed) => Self::Failed,
            (Self::DataLost, _) | (_, Self::DataLost) => Self::DataLost,
            _ => self,
        }
    }

    /// This outcome, or `Failed` in place of `Done` if standard output could not be written. That is reported, unless the reader
    /// has closed the pipe, as `head` does.
    pub fn if_output_was_taken(self) -> Self {
        note_output(std::io::stdout().flush());
        let Some(error) = LOST_OUTPUT.get() else { return self };
        operator::tell_lost_output(error);
        if self == Self::Done { Self::Failed } else { self }
    }
}

/// A command line whose arguments do not go together.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct UsageError(pub anyhow::Error);

/// A library's error, with the options that its advice is about.
pub fn with_options(error: impl std::error::Error + Send + Sync + 'static, options: &str) -> anyhow::Error {
    anyhow::anyhow!("{error} ({options})")
}

pub fn is_output_json() -> bool {
    OUTPUT_IS_JSON.load(Ordering::Relaxed)
}

/// Prints a sentence, or lines that are laid out already, for the operator on standard output, without trailing blanks.
///
/// An error is kept for [`Outcome::if_output_was_taken`].
pub fn say(lines: impl std::fmt::Display) {
    let lines = lines.to_string();
    let lines = visible(&lines);
    let trimmed = lines.split('\n').map(str::trim_end).collect::<Vec<_>>().join("\n");
    if is_output_json() {
        print_error(&trimmed);
    } else {
        print(&for_terminal(&trimmed, std::io::stdout().is_terminal()));
    }
}

/// A sentence in lines that fit a terminal, where it goes to one; a file and another program take it as a single line.
fn for_terminal(sentence: &str, is_terminal: bool) -> String {
    if !is_terminal || sentence.contains('\n') {
        return sentence.to_owned();
    }
    paragraph(sentence).join("\n")
}

/// Prints a result line by line, unless standard output is reserved for it as JSON.
pub fn show<Line: std::fmt::Display>(lines: impl IntoIterator<Item = Line>) {
    if !is_output_json() {
        lines.into_iter().for_each(say);
    }
}

pub fn print(text: &str) {
    with_panel_suspended(|| note_output(writeln!(std::io::stdout(), "{text}")));
}

/// Prints a remark for the operator on standard error.
pub fn remark(line: impl std::fmt::Display) {
    print_error(&operator::one_line(&line.to_string()));
}

fn print_error(text: &str) {
    let text = for_terminal(text, std::io::stderr().is_terminal());
    // A closed terminal is no reason to stop.
    with_panel_suspended(|| drop(writeln!(std::io::stderr(), "{text}")));
}

fn note_output(printed: std::io::Result<()>) {
    if let Err(error) = printed {
        // The first failure is the one that matters.
        let _ = LOST_OUTPUT.set(error);
    }
}

/// Registers the panel that is suspended while anything is printed, for as long as its owner keeps it.
pub fn hold_panel(panel: &ProgressBar) {
    *PANEL.lock().unwrap_or_else(PoisonError::into_inner) = Some(panel.downgrade());
}

fn with_panel_suspended(print: impl FnOnce()) {
    let panel = PANEL.lock().unwrap_or_else(PoisonError::into_inner).clone();
    panel.and_then(|panel| panel.upgrade()).unwrap_or_else(ProgressBar::hidden).suspend(print);
}
