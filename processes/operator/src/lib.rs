//! What every program says to its operator: an error in one line, and nothing that commands a terminal.
//!
//! Names of files, knobs and models, and whatever a foreign file holds, reach the operator's screen in messages. There a
//! control character would move the cursor or rename the window, and a bidirectional one turn a name around. So everything
//! that is printed passes [`visible`] or [`one_line`] on its way out, and nothing before that needs to know.

mod log;

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{ErrorKind, Write as _};
use std::process::ExitCode;

pub use log::{log_may_be_coloured, start_log};
pub use tracing_subscriber::filter::LevelFilter;

/// Most characters of an error: a dozen lines of a terminal.
const LONGEST_ERROR: usize = 1000;

/// The text with every character shown that a terminal would obey instead, as JSON and TOML write it; line ends stay.
#[must_use]
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.chars().any(commands) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        if commands(character) {
            let _ = write!(shown, "\\u{:04x}", u32::from(character));
        } else {
            shown.push(character);
        }
    }
    Cow::Owned(shown)
}

/// The text as one line of bounded length, with every character shown that a terminal would obey; of a longer one the
/// beginning and the end, which says what to do.
#[must_use]
pub fn one_line(text: &str) -> String {
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = visible(&words);
    let length = line.chars().count();
    if length <= LONGEST_ERROR {
        return line.into_owned();
    }
    let half = LONGEST_ERROR / 2;
    let beginning: String = line.chars().take(half).collect();
    let end: String = line.chars().skip(length - half).collect();
    format!("{beginning} ... {end}")
}

/// Control characters but the line end, and those that turn the direction of writing or are not seen at all.
fn commands(character: char) -> bool {
    let is_direction = matches!(character, '\u{61c}' | '\u{200b}' | '\u{200e}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{2069}');
    let is_other_line_end = matches!(character, '\u{2028}' | '\u{2029}');
    (character.is_control() && character != '\n') || is_direction || is_other_line_end || character == '\u{feff}'
}

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

/// Tells that standard output was not written; whoever closed a pipe, as `head` does, knows.
pub fn tell_lost_output(error: &std::io::Error) -> ExitCode {
    if error.kind() != ErrorKind::BrokenPipe {
        print_error(&format!("error: standard output could not be written ({error}); make room, or send it elsewhere"));
    }
    ExitCode::FAILURE
}

/// The command line; help and version are printed as they are asked for, and what is wrong is told in three lines at most.
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
    let (usage, told): (Vec<&String>, Vec<&String>) =
        paragraphs.iter().partition(|line| line.starts_with("Usage:") || line.starts_with("For more"));
    print_error(&told.into_iter().map(String::as_str).collect::<Vec<_>>().join("; "));
    usage.into_iter().take(2).for_each(|line| print_error(line));
    ExitCode::from(2)
}

#[cfg(test)]
mod tests {
    use super::{LONGEST_ERROR, one_line, visible};

    #[test]
    fn nothing_printed_commands_a_terminal() {
        assert_eq!(visible("knob ü 3\nnext"), "knob ü 3\nnext");
        assert_eq!(visible("a\u{1b}[2Jb\u{7}\u{9b}1m\u{202e}c\r"), "a\\u001b[2Jb\\u0007\\u009b1m\\u202ec\\u000d");
    }

    #[test]
    fn an_error_is_one_line_of_bounded_length_that_keeps_its_end() {
        assert_eq!(one_line("bad\n  |\n3 | x = \u{1b}\n"), "bad | 3 | x = \\u001b");
        let long = one_line(&format!("{} is wrong: run this", "x".repeat(5_000_000)));
        assert!(long.chars().count() < LONGEST_ERROR + 10);
        assert!(long.starts_with("xxx") && long.ends_with("is wrong: run this"));
    }
}
