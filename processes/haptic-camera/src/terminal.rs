//! The terminal: whether there is one to draw on, and tables and numbers for one of 80 columns.

use std::io::IsTerminal as _;

use comfy_table::{CellAlignment, ContentArrangement, Row, Table, presets};
use console::measure_text_width;
pub use identification::statistics::digits;
use indicatif::{ProgressBar, ProgressStyle};

pub const WIDTH: u16 = 80;

/// Lines, and characters in a line, of the terminal that both results and remarks go to; `None` where either goes elsewhere, or the
/// terminal cannot move its cursor.
pub fn size() -> Option<(u16, u16)> {
    let dumb = std::env::var_os("TERM").is_none_or(|name| name == "dumb");
    if dumb || !std::io::stdout().is_terminal() || !std::io::stderr().is_terminal() {
        return None;
    }
    console::Term::stderr().size_checked()
}

/// A progress bar of that many steps, if they are known.
pub fn bar(steps: Option<u64>, template: &str) -> ProgressBar {
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    steps.map_or_else(ProgressBar::no_length, ProgressBar::new).with_style(style)
}

/// A table without rules: a header and rows, the columns at the places `right` aligned to the right. On a terminal it is at most
/// [`WIDTH`] wide.
pub fn table<Cells: Into<Row>>(
    header: impl Into<Row>,
    right: impl IntoIterator<Item = usize>,
    rows: impl IntoIterator<Item = Cells>,
) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_header(header).add_rows(rows);
    for index in right {
        if let Some(column) = table.column_mut(index) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    if std::io::stdout().is_terminal() && width(&table) > WIDTH {
        table.column_iter_mut().for_each(|column| {
            column.set_padding((0, 1));
        });
        table.set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    }
    table
}

/// Columns of the terminal that a table takes where nothing narrows it.
pub fn width(table: &Table) -> u16 {
    table.column_max_content_widths().iter().map(|content| content + 2).sum::<u16>().saturating_sub(1)
}

/// A sentence in lines of at most [`WIDTH`] columns, unless a word is longer. Lines after the first are indented past the
/// sentence's dash, or past its label, which two blanks end.
pub fn paragraph(sentence: &str) -> Vec<String> {
    let indent = indent(sentence);
    let (mark, words) = sentence.split_at_checked(indent).unwrap_or(("", sentence));
    let mut lines = Vec::new();
    let mut line = mark.to_owned();
    for (index, word) in words.split(' ').enumerate() {
        if index > 0 && measure_text_width(&line) + 1 + measure_text_width(word) > usize::from(WIDTH) {
            lines.push(std::mem::replace(&mut line, " ".repeat(indent)));
        } else if index > 0 {
            line.push(' ');
        }
        line += word;
    }
    lines.push(line);
    lines
}

/// Longest label before a sentence, with its blanks.
const LABEL: usize = 12;

fn indent(sentence: &str) -> usize {
    let text = sentence.trim_start();
    let label = text.starts_with("- ").then_some(2).or_else(|| {
        let (label, words) = text.split_once("  ")?;
        Some(label.len() + 2 + words.len() - words.trim_start().len()).filter(|length| *length <= LABEL)
    });
    sentence.len() - text.len() + label.unwrap_or(0)
}

/// Texts line by line, each line as a [`paragraph`].
pub fn paragraphs(texts: &[String]) -> Vec<String> {
    texts.iter().flat_map(|text| text.split('\n')).flat_map(|line| paragraph(line.trim_end())).collect()
}

/// A number with so many decimals; nothing for none.
pub fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(String::new, |value| format!("{value:.digits$}"))
}

/// An interval with so many decimals; nothing for none.
pub fn interval(ci95: Option<[f64; 2]>, digits: usize) -> String {
    ci95.map_or_else(String::new, |[low, high]| format!("{low:.digits$} to {high:.digits$}"))
}

/// Names with the reason that they have in common: one line for each reason.
pub fn by_reason<'a>(named: impl IntoIterator<Item = (&'a str, &'a str)>) -> Vec<String> {
    let mut lines: Vec<(Vec<&str>, &str)> = Vec::new();
    for (name, reason) in named {
        match lines.iter_mut().find(|(_, known)| *known == reason) {
            Some((names, _)) => names.push(name),
            None => lines.push((vec![name], reason)),
        }
    }
    lines.into_iter().map(|(names, reason)| format!("{}: {reason}", names.join(", "))).collect()
}

/// Decimals that show a value with so many digits, within bounds.
pub fn decimals(value: f64, digits: f64, [least, most]: [f64; 2]) -> usize {
    let order = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    (digits - 1.0 - order).clamp(least, most) as usize
}
