//! A table as text: what stands above its columns, their names, and its rows.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::Path;

use shared_types::Quantity;

use super::separator::{BLANKS, LOOKED_AT, separator, with_tabulators};
use crate::error::ArchiveError;

/// Most columns, and letters of each, that an error quotes.
const QUOTED: (usize, usize) = (20, 40);
/// What most cells are to be.
const A_NUMBER: &str = "a number";

/// The cells of a table.
#[derive(Debug, Default)]
pub(super) struct RawTable {
    /// Lines above the names of the columns.
    pub(super) preamble: Vec<csv::StringRecord>,
    /// The names of the columns; empty where there are none.
    pub(super) header: Vec<String>,
    /// How many cells the header has, with those at its end that are empty.
    header_cells: usize,
    /// The units of the columns, where they stand in a row of their own below the names; otherwise empty.
    pub(super) units: Vec<String>,
    /// The rows of numbers.
    pub(super) rows: Vec<csv::StringRecord>,
    /// What stands between cells.
    separator: u8,
}

impl RawTable {
    pub(super) fn read(path: &Path) -> Result<Self, ArchiveError> {
        let mut bytes = Vec::new();
        foreign_files::open(path)
            .and_then(|mut file| file.read_to_end(&mut bytes))
            .map_err(|error| ArchiveError::file(path, error))?;
        Self::of(&foreign_files::decoded(&bytes)).map_err(|error| super::wrong(path, error.to_string()))
    }

    pub(super) fn of(text: &str) -> Result<Self, csv::Error> {
        let separator = separator(text);
        let (text, delimiter) = match separator {
            BLANKS => (Cow::Owned(text.lines().map(with_tabulators).collect()), b'\t'),
            other => (Cow::Borrowed(text), other),
        };
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .delimiter(delimiter)
            .from_reader(text.as_bytes());
        let (mut records, mut comments) = (Vec::new(), Vec::new());
        for record in reader.records() {
            let record = record?;
            if is_comment(&record, separator) {
                comments.push((records.len(), record));
            } else if record.iter().any(|cell| !cell.is_empty()) {
                records.push(record);
            }
        }
        let mut table = Self { separator, ..Self::default() };
        let first = table.first_row(&records);
        let mut rows = records.split_off(first);
        // What stands below the rows is passed over, as are rows there without values, and a last row that was cut off.
        let last = rows.iter().rposition(|record| table.readings(record) > 1);
        let last = last.or_else(|| rows.iter().rposition(|record| table.numbers(record) > 1));
        rows.truncate(last.map_or(0, |last| last + 1));
        let whole = rows.first().map_or(0, csv::StringRecord::len);
        if rows.len() > 1 && rows[rows.len() - 2].len() >= whole {
            let _ = rows.pop_if(|last| last.len() < whole);
        }
        table.rows = rows;
        let is_header =
            |record: &mut csv::StringRecord| record.len() > 1 && !record.iter().any(|cell| cell.contains('='));
        let cells = table.rows.first().map_or(0, csv::StringRecord::len);
        // Where blanks separate cells, a name with a blank in it looks like two names.
        let is_whole = |record: &csv::StringRecord| separator != BLANKS || record.len() == cells;
        let header = records.pop_if(is_header).filter(is_whole).or_else(|| {
            let above = comments.iter().rev().find(|(at, _)| *at <= first)?;
            Some(uncommented(&above.1)).filter(|record| record.len() == cells)
        });
        let mut header = header;
        if header.as_ref().is_some_and(are_units)
            && let Some(names) = records.pop_if(|record| is_header(record) && is_whole(record))
        {
            table.units = header.iter().flatten().map(str::to_owned).collect();
            header = Some(names);
        }
        table.header = header.iter().flatten().map(str::to_owned).collect();
        table.header_cells = table.header.len();
        while table.header.pop_if(|name| name.is_empty()).is_some() {}
        table.preamble = records;
        Ok(table)
    }

    /// The first of the rows: numbers stand in the same places of nearly all, and may be missing in some.
    fn first_row(&self, records: &[csv::StringRecord]) -> usize {
        let places = |record: &csv::StringRecord| -> Vec<bool> {
            record.iter().take(filled(record)).map(|cell| self.is_meant_as_number(cell)).collect()
        };
        let mut kinds: BTreeMap<Vec<bool>, usize> = BTreeMap::new();
        for record in records.iter().take(LOOKED_AT).filter(|record| self.numbers(record) > 1) {
            *kinds.entry(places(record)).or_default() += 1;
        }
        let Some((typical, _)) = kinds.into_iter().max_by_key(|(_, count)| *count) else { return records.len() };
        let first = records.iter().position(|record| places(record) == typical).unwrap_or(records.len());
        let is_row = |record: &&csv::StringRecord| {
            let places = places(record);
            // The last cells may be the empty ones.
            let has_fewer = places.len() <= typical.len()
                && record.len() >= typical.len()
                && places.iter().zip(&typical).all(|(here, usual)| here <= usual);
            has_fewer || places.len() >= typical.len() && typical.iter().zip(&places).all(|(usual, here)| usual <= here)
        };
        first - records[..first].iter().rev().take_while(|record| self.numbers(record) > 1 && is_row(record)).count()
    }

    /// How many cells are numbers, or are meant so: a row is not passed over because its numbers are refused.
    fn numbers(&self, record: &csv::StringRecord) -> usize {
        record.iter().filter(|cell| self.is_meant_as_number(cell)).count()
    }

    /// How many of them are no words for a missing number.
    fn readings(&self, record: &csv::StringRecord) -> usize {
        record.iter().filter(|cell| self.is_meant_as_number(cell) && !is_missing(cell)).count()
    }

    fn is_meant_as_number(&self, cell: &str) -> bool {
        let is_quoted = || self.separator == b',' && cell.contains(',') && cell.replace(',', "").parse::<f64>().is_ok();
        self.number(cell).is_some() || foreign_files::has_thousands(cell) || is_missing(cell) || is_quoted()
    }

    /// A number as the table writes it; `None` for what is none.
    pub(super) fn number(&self, cell: &str) -> Option<f64> {
        foreign_files::with_point(cell, self.separator).parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// The numbers of a column, each times `factor`.
    pub(super) fn column(&self, index: usize, factor: f64) -> Result<Vec<f64>, String> {
        let column = self.cells(index, |cell| self.number(cell).map(|value| value * factor), A_NUMBER)?;
        if self.separator != b',' {
            let mut marks = foreign_files::Marks::default();
            for record in &self.rows {
                marks.note(record.get(index).unwrap_or_default(), line_of(record));
            }
            if let Some((line, reason)) = marks.doubt(&self.name(index)) {
                return Err(format!("line {line}: {reason}"));
            }
        }
        Ok(column)
    }

    /// The numbers of a column in which only levels are told apart, whatever the marks in them mean.
    pub(super) fn levels(&self, index: usize) -> Result<Vec<f64>, String> {
        self.cells(index, |cell| self.number(cell), A_NUMBER)
    }

    /// The name of a column, or else its number.
    fn name(&self, index: usize) -> String {
        self.header.get(index).cloned().unwrap_or_else(|| (index + 1).to_string())
    }

    /// The cells of a column, each as `parse` takes it.
    pub(super) fn cells<T>(
        &self,
        index: usize,
        parse: impl Fn(&str) -> Option<T>,
        what: &str,
    ) -> Result<Vec<T>, String> {
        let cell = |record: &csv::StringRecord| {
            let text = record.get(index).unwrap_or_default();
            parse(text).ok_or_else(|| {
                let shown: String = text.chars().take(QUOTED.1).collect();
                let (name, line) = (self.name(index), line_of(record));
                let has_marks = text.contains(',') || foreign_files::has_thousands(text);
                let remedy = if has_marks && what == A_NUMBER {
                    "write it with a point, and without separators of thousands"
                } else {
                    "correct it, or leave the line out"
                };
                format!("line {line}: `{shown}` in the column {name} is not {what}; {remedy}")
            })
        };
        self.rows.iter().map(cell).collect()
    }

    /// The line of a row that has more cells than the header has, so that names and cells do not belong together: decimal commas part its
    /// numbers, or every row has a cell without a name, as R writes the names of rows.
    pub(super) fn parted_row(&self) -> Option<u64> {
        if self.separator != b',' || self.header.is_empty() {
            return None;
        }
        let are_digits = |cell: &str| cell.trim_start_matches('-').bytes().all(|byte| byte.is_ascii_digit());
        let is_parted =
            |record: &&csv::StringRecord| filled(record) > self.header.len() && record.iter().all(are_digits);
        // A line with a number is none of names, though it stands above rows without any.
        let has_names = !self.header.iter().any(|name| self.number(name).is_some());
        let are_longer = || self.rows.iter().all(|record| filled(record) > self.header_cells);
        let first = self.rows.first().filter(|_| has_names && are_longer());
        first.or_else(|| self.rows.iter().find(is_parted)).map(line_of)
    }

    /// Place of a column by its name, whatever its case; `None` also where several have it.
    pub(super) fn place(&self, name: &str) -> Option<usize> {
        let mut places = (0..self.header.len()).filter(|column| self.header[*column].eq_ignore_ascii_case(name));
        places.next().filter(|_| places.next().is_none())
    }

    /// Number of columns.
    pub(super) fn width(&self) -> usize {
        self.header.len().max(self.rows.first().map_or(0, csv::StringRecord::len))
    }

    /// The columns in words.
    pub(super) fn columns(&self) -> String {
        if self.header.is_empty() {
            return match self.rows.first() {
                Some(row) => format!("{} columns of numbers without names", row.len()),
                None => "no columns of numbers".to_owned(),
            };
        }
        let shown = self.header.iter().take(QUOTED.0).map(|name| {
            let name: String = name.chars().filter(|letter| !letter.is_control()).take(QUOTED.1).collect();
            format!("`{name}`")
        });
        let more = if self.header.len() > QUOTED.0 { " and more" } else { "" };
        format!("the columns {}{more}", shown.collect::<Vec<_>>().join(", "))
    }
}

/// Number of cells up to the last that is not empty.
fn filled(record: &csv::StringRecord) -> usize {
    (0..record.len()).rev().find(|at| !record[*at].is_empty()).map_or(0, |last| last + 1)
}

/// Whether a cell stands for a number that is missing, as NaN does.
fn is_missing(cell: &str) -> bool {
    cell.parse::<f64>().is_ok_and(|value| !value.is_finite())
        || ["NA", "N/A"].iter().any(|word| cell.eq_ignore_ascii_case(word))
}

fn line_of(record: &csv::StringRecord) -> u64 {
    record.position().map_or(0, csv::Position::line)
}

/// A unit without the brackets around it.
pub(super) fn without_brackets(unit: &str) -> &str {
    unit.trim_matches(['[', ']', '(', ')', ' '])
}

/// Longest unit, in letters.
const LONGEST_UNIT: usize = 8;

/// Whether the cells are units, in brackets or not: two that this instrument works with, at least, and of other columns short ones.
fn are_units(record: &csv::StringRecord) -> bool {
    let quantities = [Quantity::Angle, Quantity::Torque, Quantity::Travel, Quantity::Force, Quantity::Time];
    let is_known =
        |cell: &&str| quantities.iter().any(|quantity| quantity.factor_in_any_case(without_brackets(cell)).is_some());
    record.iter().filter(is_known).count() > 1 && record.iter().all(|cell| cell.chars().count() <= LONGEST_UNIT)
}

/// Whether a line is a comment; a percent sign may also be a unit.
fn is_comment(record: &csv::StringRecord, separator: u8) -> bool {
    let first = &record[0];
    let may_be = first.len() > 1 || separator == BLANKS;
    first.starts_with('#') || first.starts_with('%') && may_be && !are_units(record)
}

/// A comment's cells without its mark.
fn uncommented(record: &csv::StringRecord) -> csv::StringRecord {
    let cells = record
        .iter()
        .enumerate()
        .map(|(index, cell)| if index == 0 { cell.trim_start_matches(['#', '%']).trim() } else { cell });
    cells.enumerate().filter(|(index, cell)| *index > 0 || !cell.is_empty()).map(|(_, cell)| cell).collect()
}
