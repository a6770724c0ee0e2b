//! Text that others wrote, shown so that it commands no terminal.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Most characters of a line: a dozen lines of a terminal.
const LONGEST_LINE: usize = 1000;

/// The text of a table that somebody else's program wrote: UTF-8, UTF-16 with its byte order mark, or else Windows-1252, in which spreadsheets of
/// western Europe write `°` and `µ`.
#[must_use]
pub fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let encoding = if std::str::from_utf8(bytes).is_ok() { encoding_rs::UTF_8 } else { encoding_rs::WINDOWS_1252 };
    // A byte order mark overrules it, and is removed.
    encoding.decode(bytes).0
}

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

/// The text as one line of bounded length, with control characters made visible. Of a longer text the beginning and the end
/// are kept: the end of a message says what to do.
#[must_use]
pub fn one_line(text: &str) -> String {
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    let line = visible(&words);
    let length = line.chars().count();
    if length <= LONGEST_LINE {
        return line.into_owned();
    }
    let half = LONGEST_LINE / 2;
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

#[cfg(test)]
mod tests {
    use super::{LONGEST_LINE, one_line, visible};

    #[test]
    fn nothing_printed_commands_a_terminal() {
        assert_eq!(visible("knob ü 3\nnext"), "knob ü 3\nnext");
        assert_eq!(visible("a\u{1b}[2Jb\u{7}\u{9b}1m\u{202e}c\r"), "a\\u001b[2Jb\\u0007\\u009b1m\\u202ec\\u000d");
    }

    #[test]
    fn an_error_is_one_line_of_bounded_length_that_keeps_its_end() {
        assert_eq!(one_line("bad\n  |\n3 | x = \u{1b}\n"), "bad | 3 | x = \\u001b");
        let long = one_line(&format!("{} is wrong: run this", "x".repeat(5_000_000)));
        assert!(long.chars().count() < LONGEST_LINE + 10);
        assert!(long.starts_with("xxx") && long.ends_with("is wrong: run this"));
    }
}
