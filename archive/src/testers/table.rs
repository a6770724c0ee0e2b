//! A table as text: what stands above its columns, their names, and its rows.

use std::io::Read as _;
use std::path::Path;

use crate::error::ArchiveError;

/// Most columns, and letters of each, that an error quotes.
const QUOTED: (usize, usize) = (20, 40);

/// The cells of a table.
#[derive(Debug, Default)]
pub(super) struct RawTable {
    /// Lines above the names of the columns.
    pub(super) preamble: Vec<csv::StringRecord>,
    /// The names of the columns; empty where there are none.
    pub(super) header: Vec<String>,
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
        // Testers write units such as µm in whatever encoding their machine has.
        let text = String::from_utf8_lossy(&bytes);
        let text = text.trim_start_matches('\u{feff}');
        let separator = foreign_files::separator(text.as_bytes());
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .trim(csv::Trim::All)
            .delimiter(separator)
            .from_reader(text.as_bytes());
        let mut records = Vec::new();
        for record in reader.records() {
            let record = record.map_err(|error| super::wrong(path, error.to_string()))?;
            if record.iter().any(|cell| !cell.is_empty()) && !record[0].starts_with('#') {
                records.push(record);
            }
        }
        let mut table = Self { separator, ..Self::default() };
        let first = records
            .iter()
            .position(|record| record.iter().filter(|cell| table.number(cell).is_some()).count() > 1)
            .unwrap_or(records.len());
        table.rows = records.split_off(first);
        if records.last().is_some_and(|record| record.len() > 1 && !record.iter().any(|cell| cell.contains('=')))
            && let Some(header) = records.pop()
        {
            table.header = header.iter().map(str::to_owned).collect();
            while table.header.last().is_some_and(String::is_empty) {
                table.header.pop();
            }
        }
        table.preamble = records;
        Ok(table)
    }

    /// A number as the table writes it; `None` for what is none.
    pub(super) fn number(&self, cell: &str) -> Option<f64> {
        foreign_files::with_point(cell, self.separator).parse().ok().filter(|value: &f64| value.is_finite())
    }

    /// The numbers of a column, each times `factor`.
    pub(super) fn column(&self, index: usize, factor: f64) -> Result<Vec<f64>, String> {
        self.cells(index, |cell| self.number(cell).map(|value| value * factor), "a number")
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
                let name = self.header.get(index).cloned().unwrap_or_else(|| (index + 1).to_string());
                let line = record.position().map_or(0, csv::Position::line);
                format!("line {line}: `{shown}` in the column {name} is not {what}")
            })
        };
        self.rows.iter().map(cell).collect()
    }

    /// Place of a column by its name, whatever its case.
    pub(super) fn place(&self, name: &str) -> Option<usize> {
        self.header.iter().position(|found| found.eq_ignore_ascii_case(name))
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
