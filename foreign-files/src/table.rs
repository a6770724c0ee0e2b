//! Tables of numbers as text.
//!
//! A table has a line of column names, and below it one row of numbers a line; what stands above that line is passed over. Columns may stand in any order, and their names
//! be written in capitals. A byte order mark, Windows line ends, quotation marks, blanks around cells, empty lines, lines that begin
//! with `#` (but for a header written so) and separators at the ends of lines are passed over. Commas, semicolons or tabulators separate cells. Numbers are finite and
//! written with a point, beside semicolons or tabulators also with a comma; a column in which a mark may part thousands is refused.

use std::borrow::Cow;
use std::io::{BufRead, BufReader, Read};

use crate::marks::{Marks, has_thousands};

/// Characters of somebody else's text that an error quotes.
const QUOTED: usize = 200;
/// Bytes at the beginning of a table from which its separator is determined.
const HEAD: usize = 4096;

/// A column that is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    name: &'static str,
    required: bool,
}

impl Column {
    /// One that every such table has.
    #[must_use]
    pub const fn required(name: &'static str) -> Self {
        Self { name, required: true }
    }

    /// One that a table may have.
    #[must_use]
    pub const fn optional(name: &'static str) -> Self {
        Self { name, required: false }
    }
}

/// What becomes of columns that nobody looks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherColumns {
    /// A table that has any is refused: its author meant something by them.
    Refused,
    /// They are ignored.
    Ignored,
}

/// Why a table cannot be read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TableError {
    /// No line names the columns.
    #[error("it has the columns `{found}`, but they must be `{expected}`")]
    Header {
        /// The columns that were found, shortened.
        found: String,
        /// The columns as they should be, optional ones in brackets.
        expected: String,
    },
    /// A line is no row of numbers.
    #[error("line {line}: {reason}")]
    Line {
        /// Line, counted from 1; where empty lines or comments stand before the row, the first of them.
        line: u64,
        /// What is wrong with it.
        reason: String,
    },
    /// The bytes are not UTF-8.
    #[error("it is not UTF-8 text")]
    NotText,
    /// The system could not read on.
    #[error("{reason}")]
    System {
        /// The system's error.
        kind: std::io::ErrorKind,
        /// Its words.
        reason: String,
    },
}

/// Reads the `wanted` columns of a table; `None` for an optional one that is not there.
///
/// # Errors
/// [`TableError`], with the line where there is one.
pub fn read_columns<const N: usize>(
    text: impl Read,
    wanted: [Column; N],
    others: OtherColumns,
) -> Result<[Option<Vec<f64>>; N], TableError> {
    Ok(read_labelled(text, wanted, [], others)?.0)
}

/// Columns of numbers, `None` for optional ones that are not there, and columns of text.
pub type Labelled<const N: usize, const M: usize> = ([Option<Vec<f64>>; N], [Vec<String>; M]);

/// The same, with the columns of `labels` as text; they are empty where the table has none.
///
/// # Errors
/// As [`read_columns`].
pub fn read_labelled<const N: usize, const M: usize>(
    text: impl Read,
    wanted: [Column; N],
    labels: [&str; M],
    others: OtherColumns,
) -> Result<Labelled<N, M>, TableError> {
    let mut text = BufReader::with_capacity(HEAD, text);
    let required = wanted.iter().filter(|column| column.required).map(|column| column.name);
    let head = text.fill_buf().map_err(from_io)?;
    let above = preamble(head, &required.collect::<Vec<_>>());
    let preamble = above.unwrap_or_default();
    let lines_above = preamble.iter().filter(|byte| **byte == b'\n').count() as u64;
    let table = &head[preamble.len()..];
    // A header that is a comment, as NumPy writes it, is not passed over.
    let mark = table.iter().take_while(|byte| above.is_some() && b"# ".contains(byte)).count();
    let separator = separator(header_line(table));
    let above = preamble.len() + mark;
    text.consume(above);
    let mut table = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .flexible(true)
        .delimiter(separator)
        .from_reader(text);
    let from_csv = |error| from_csv(error, lines_above);
    let header = table.headers().map_err(from_csv)?.clone();
    let mut names: Vec<&str> = header.iter().map(|name| name.trim_start_matches('\u{feff}').trim()).collect();
    while names.last().is_some_and(|name| name.is_empty()) {
        names.pop();
    }
    let places = places(&names, &wanted, others)?;
    let mut columns = places.map(|place| place.map(|_| Vec::new()));
    let label_places = labels.map(|label| names.iter().position(|name| name.eq_ignore_ascii_case(label)));
    let mut label_columns = [const { Vec::new() }; M];
    let mut marks = [const { None::<Marks> }; N];
    let mut record = csv::StringRecord::new();
    while table.read_record(&mut record).map_err(from_csv)? {
        let line = record.position().map_or(0, csv::Position::line) + lines_above;
        let wrong = |reason| TableError::Line { line, reason };
        if record.len() < names.len() || record.iter().skip(names.len()).any(|cell| !cell.is_empty()) {
            return Err(wrong(wrong_length(record.len(), names.len())));
        }
        for (((place, column), Column { name, .. }), marks) in
            places.iter().zip(&mut columns).zip(&wanted).zip(&mut marks)
        {
            if let (Some(place), Some(column)) = (place, column) {
                column.push(number(&record[*place], separator, name).map_err(wrong)?);
                if separator != b',' {
                    marks.get_or_insert_default().note(&record[*place], line);
                }
            }
        }
        for (place, column) in label_places.iter().zip(&mut label_columns) {
            column.extend(place.map(|place| record[place].to_owned()));
        }
    }
    let doubt = |(marks, column): (&Option<Marks>, &Column)| marks.as_ref()?.doubt(column.name);
    if let Some((line, reason)) = marks.iter().zip(&wanted).find_map(doubt) {
        return Err(TableError::Line { line, reason });
    }
    Ok((columns, label_columns))
}

/// Where the wanted columns stand.
fn places<const N: usize>(
    names: &[&str],
    wanted: &[Column; N],
    others: OtherColumns,
) -> Result<[Option<usize>; N], TableError> {
    let places = wanted.map(|column| names.iter().position(|name| name.eq_ignore_ascii_case(column.name)));
    let complete = wanted.iter().zip(&places).all(|(column, place)| place.is_some() || !column.required);
    let count = |column: &Column| names.iter().filter(|name| name.eq_ignore_ascii_case(column.name)).count();
    let unique = wanted.iter().all(|column| count(column) <= 1);
    // A column without a name, as pandas writes its index, means nothing.
    let named = names.iter().filter(|name| !name.is_empty()).count();
    let foreign = named > places.iter().flatten().count();
    if complete && unique && (others == OtherColumns::Ignored || !foreign) {
        return Ok(places);
    }
    let expected = wanted.iter().enumerate().map(|(index, Column { name, required })| {
        let comma = if index == 0 { "" } else { "," };
        if *required { format!("{comma}{name}") } else { format!("[{comma}{name}]") }
    });
    let found = names.join(",");
    Err(TableError::Header { found: quoted(&found), expected: expected.collect() })
}

/// What stands above the line that names all these columns, at a text's beginning; `None` where no line does. The line may be a comment, if no
/// other names them.
#[must_use]
pub fn preamble<'a>(text: &'a [u8], names: &[&str]) -> Option<&'a [u8]> {
    let head = text.get(..HEAD).unwrap_or(text);
    let names_all = |line: &[u8]| {
        let found = String::from_utf8_lossy(line);
        let separator = char::from(separator(line));
        let cells: Vec<&str> = found.split(separator).map(|cell| cell.trim().trim_matches(['"', '\u{feff}'])).collect();
        names.iter().all(|name| cells.iter().any(|cell| cell.eq_ignore_ascii_case(name)))
    };
    let mut start = 0;
    let mut in_comment = None;
    for line in head.split_inclusive(|byte| *byte == b'\n') {
        let marks = line.iter().take_while(|byte| **byte == b'#').count();
        if names_all(&line[marks..]) {
            if marks == 0 {
                return Some(&head[..start]);
            }
            in_comment.get_or_insert(&head[..start]);
        }
        start += line.len();
    }
    in_comment
}

/// The first line that is neither empty nor a comment.
fn header_line(head: &[u8]) -> &[u8] {
    let is_header = |line: &&[u8]| !line.starts_with(b"#") && !line.trim_ascii().is_empty();
    head.split(|byte| *byte == b'\n').find(is_header).unwrap_or_default()
}

/// The separator of a header's cells: semicolons or tabulators if there are any, since commas beside them are decimal commas; else commas.
fn separator(header: &[u8]) -> u8 {
    let count = |separator: u8| header.iter().filter(|byte| **byte == separator).count();
    let (semicolons, tabulators) = (count(b';'), count(b'\t'));
    if semicolons > 0 && semicolons >= tabulators {
        b';'
    } else if tabulators > 0 {
        b'\t'
    } else {
        b','
    }
}

/// A number as a table with this separator writes it, with a decimal point.
#[must_use]
pub fn with_point(cell: &str, separator: u8) -> Cow<'_, str> {
    if separator == b',' { Cow::Borrowed(cell) } else { Cow::Owned(cell.replace(',', ".")) }
}

fn number(cell: &str, separator: u8, column: &str) -> Result<f64, String> {
    match with_point(cell, separator).parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(value) => Err(format!("{column} is {value}, but it must be a finite number")),
        Err(_) if cell.is_empty() => {
            Err(format!("the column {column} has no value; fill it in, or leave the line out"))
        }
        Err(_) => {
            let hint = if cell.contains(',') || has_thousands(cell) {
                "; write it with a point, and without separators of thousands"
            } else {
                "; correct it, or leave the line out"
            };
            Err(format!("`{}` in the column {column} is not a number{hint}", quoted(cell)))
        }
    }
}

fn wrong_length(found: usize, expected: usize) -> String {
    let hint = if found > expected { "; write numbers with a point, as in 1.5" } else { "" };
    format!("it has {found} cells, but the header has {expected}{hint}")
}

/// The beginning of a text that may be a whole file.
fn quoted(text: &str) -> String {
    let visible = |character: char| if character.is_control() { ' ' } else { character };
    let mut shown: String = text.chars().map(visible).take(QUOTED).collect();
    if text.chars().nth(QUOTED).is_some() {
        shown.push_str("...");
    }
    shown
}

fn from_csv(error: csv::Error, lines_above: u64) -> TableError {
    let line = error.position().map_or(0, csv::Position::line) + lines_above;
    match error.into_kind() {
        csv::ErrorKind::Io(error) => from_io(error),
        csv::ErrorKind::Utf8 { .. } => TableError::NotText,
        other => TableError::Line { line, reason: format!("{other:?}") },
    }
}

#[allow(clippy::needless_pass_by_value, reason = "an argument of `map_err`")]
fn from_io(error: std::io::Error) -> TableError {
    TableError::System { kind: error.kind(), reason: error.to_string() }
}
