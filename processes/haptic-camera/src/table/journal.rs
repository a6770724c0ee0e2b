//! The rows that are there before the table is, a line each: what a killed call leaves and the next one goes on from.

use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{BufRead as _, BufReader, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use analysis::{Cell, Row};
use anyhow::{Context as _, bail};
use archive::ArchiveError;
use archive::whole_file::{Replace, beside, write_whole};
use sheet::Specification;

use super::Seen;
use super::parquet_file::Table;

/// Rows that are written at once: what memory holds of a table of any length.
const ROWS_AT_ONCE: usize = 4096;

/// Place of the column `error` in a row.
const ERROR: usize = 1;

/// The rows of a table in the making.
pub(super) struct Journal<'spec> {
    specification: Option<&'spec Specification>,
    table: PathBuf,
    place: PathBuf,
    file: File,
    /// Where each file's line begins.
    lines: HashMap<Seen, u64>,
    end: u64,
}

/// A line: path, bytes and time of the file, then the row's cells as text, in which a number reads back to the last bit.
type Line = (PathBuf, u64, String, Vec<Option<String>>);

impl<'spec> Journal<'spec> {
    /// The journal of a table, with the files whose rows it has; a line that was cut off is written again, and so is everything
    /// that was made by another specification, which the first line names.
    pub(super) fn open(
        table: &Path,
        specification: Option<&'spec Specification>,
    ) -> anyhow::Result<(Self, HashSet<Seen>)> {
        let place = beside(table, ".incomplete");
        let unusable = || format!("{} cannot be used; choose another --out", place.display());
        let mut file = File::options().read(true).append(true).create(true).open(&place).with_context(unusable)?;
        if file.try_lock().is_err() {
            bail!("{} is in use by another `table`; wait for it, or choose another --out", place.display());
        }
        let (mut lines, mut text) = (HashMap::new(), String::new());
        let columns = Row::columns(specification);
        let head = format!("{specification:?}\n");
        let mut reader = BufReader::new(&file);
        let is_ours = reader.read_line(&mut text).is_ok_and(|_| text == head);
        if !is_ours {
            file.set_len(0).with_context(unusable)?;
            file.write_all(head.as_bytes()).with_context(unusable)?;
        }
        let mut end = head.len() as u64;
        let mut reader = BufReader::new(&file);
        reader.seek(SeekFrom::Start(end)).with_context(unusable)?;
        text.clear();
        while reader.read_line(&mut text).with_context(unusable)? > 0 && text.ends_with('\n') {
            let Some((seen, _)) = parsed(&text, &columns) else { break };
            lines.insert(seen, end);
            end += text.len() as u64;
            text.clear();
        }
        file.set_len(end).with_context(unusable)?;
        let done = lines.keys().cloned().collect();
        Ok((Self { specification, table: table.to_owned(), place, file, lines, end }, done))
    }

    pub(super) fn place(&self) -> &Path {
        &self.place
    }

    /// Keeps a row: it is there whatever happens afterwards.
    pub(super) fn add(&mut self, seen: &Seen, row: &Row) -> anyhow::Result<()> {
        let cells = row.cells().iter().map(|(_, cell)| written(cell)).collect();
        let line: Line = (seen.path.clone(), seen.bytes, seen.written_ns.to_string(), cells);
        let text = serde_json::to_string(&line)? + "\n";
        let full = || format!("{} cannot be written; free some space and run again", self.place.display());
        self.file.write_all(text.as_bytes()).with_context(full)?;
        self.lines.insert(seen.clone(), self.end);
        self.end += text.len() as u64;
        Ok(())
    }

    /// Writes the table of these files in their order and only then removes the journal; gives the number of rows with an error.
    pub(super) fn into_table(mut self, files: &[Seen]) -> anyhow::Result<usize> {
        let columns = Row::columns(self.specification);
        let mut write_rows = |place| -> anyhow::Result<usize> {
            let mut wrong = 0;
            let mut table = Table::begin(place, self.specification)?;
            for files in files.chunks(ROWS_AT_ONCE) {
                let rows = files.iter().map(|file| read_back(&mut self.file, self.lines[file], &columns));
                let rows = rows.collect::<anyhow::Result<Vec<_>>>()?;
                wrong += rows.iter().filter(|cells| matches!(cells[ERROR], Cell::Text(Some(_)))).count();
                table.add(&rows)?;
            }
            table.end()?;
            Ok(wrong)
        };
        let failed = |error| ArchiveError::File { path: self.table.clone(), error: std::io::Error::other(error) };
        let wrong = write_whole(&self.table, Replace::Nothing, |place| write_rows(place).map_err(failed))?;
        std::fs::remove_file(&self.place).with_context(|| format!("{} cannot be removed", self.place.display()))?;
        Ok(wrong)
    }
}

fn written(cell: &Cell) -> Option<String> {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.map(|count| count.to_string()),
        Cell::Real(real) => real.map(|real| real.to_string()),
    }
}

fn parsed(line: &str, columns: &[(String, Cell)]) -> Option<(Seen, Vec<Cell>)> {
    let (path, bytes, written_ns, texts): Line = serde_json::from_str(line).ok()?;
    if texts.len() != columns.len() {
        return None;
    }
    let cell = |(text, (_, empty)): (Option<String>, &(String, Cell))| {
        let Some(text) = text else { return Some(empty.clone()) };
        Some(match empty {
            Cell::Text(_) => Cell::Text(Some(text)),
            Cell::Count(_) => Cell::Count(Some(text.parse().ok()?)),
            Cell::Real(_) => Cell::Real(Some(text.parse().ok()?)),
        })
    };
    let cells = texts.into_iter().zip(columns).map(cell).collect::<Option<Vec<_>>>()?;
    Some((Seen { path, bytes, written_ns: written_ns.parse().ok()? }, cells))
}

fn read_back(journal: &mut File, start: u64, columns: &[(String, Cell)]) -> anyhow::Result<Vec<Cell>> {
    journal.seek(SeekFrom::Start(start))?;
    let mut line = String::new();
    BufReader::new(journal).read_line(&mut line)?;
    let (_, cells) = parsed(&line, columns).context("the journal was changed in the meantime; make the table again")?;
    Ok(cells)
}
