//! Whether there is a terminal to draw on, and how large it is.

use std::io::IsTerminal as _;

/// Size in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Lines.
    pub rows: u16,
    /// Characters in a line.
    pub columns: u16,
}

/// The size of the terminal that both results and remarks go to; `None` where either goes elsewhere, or the terminal cannot
/// move its cursor.
pub fn size() -> Option<Size> {
    let dumb = std::env::var_os("TERM").is_none_or(|name| name == "dumb");
    if dumb || !std::io::stdout().is_terminal() || !std::io::stderr().is_terminal() {
        return None;
    }
    console::Term::stderr().size_checked().map(|(rows, columns)| Size { rows, columns })
}
