//! The rows of a table that is not yet complete, one a line: what a killed call leaves and the next one continues from. At the
//! end they become the table, an Apache Parquet file.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufRead as _, BufReader, BufWriter, Seek as _, SeekFrom, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};

use analysis::{Cell, Row, common_axis};
use anyhow::{Context as _, bail, ensure};
use archive::ArchiveError;
use archive::whole_file::{Replace, beside, write_whole};
use dynamics::Axis;
use nix::libc::O_NOFOLLOW;
use parquet::basic::{Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::properties::WriterProperties;
use sheet::Specification;

use super::CaptureFile;
use crate::outcome::remark;
use crate::parquet_file::{begin, software, write_column};

/// Rows that are written at once, which bounds the memory for a table of any length.
const ROWS_AT_ONCE: usize = 4096;

/// How a journal begins: a file that begins otherwise is not overwritten.
const MARK: &str = "rows of a table of captures, by the specification ";

/// Place of the column `error` in a row.
const ERROR: usize = 1;

pub(super) struct Journal<'spec> {
    specification: Option<&'spec Specification>,
    table: PathBuf,
    pub(super) place: PathBuf,
    file: File,
    /// Where each file's line begins, and the axis of what was captured.
    pub(super) lines: HashMap<CaptureFile, (u64, Option<Axis>)>,
    end: u64,
}

/// A line: the file, its axis, then the row's cells as text, in which a number reads back to the last bit.
type Line = (CaptureFile, Option<Axis>, Vec<Option<String>>);

impl<'spec> Journal<'spec> {
    /// Opens the journal of a table. A line that was cut off is dropped, and so are all rows
    /// made by another specification, which the first line names: they are made again.
    pub(super) fn open(table: &Path, specification: Option<&'spec Specification>) -> anyhow::Result<Self> {
        let place = beside(table, ".incomplete");
        let unusable = || format!("{} cannot be used; choose another --out", place.display());
        let mut options = File::options();
        options.read(true).append(true).create(true).custom_flags(O_NOFOLLOW);
        let mut file = options.open(&place).with_context(unusable)?;
        if file.try_lock().is_err() {
            bail!("{} is in use by another `table`; wait for it, or choose another --out", place.display());
        }
        let (mut lines, mut text) = (HashMap::new(), Vec::new());
        let columns = Row::columns(specification).len();
        let head = format!("{MARK}{specification:?}\n");
        let mut reader = BufReader::new(&file);
        reader.read_until(b'\n', &mut text).with_context(unusable)?;
        ensure!(
            text.starts_with(MARK.as_bytes()) || MARK.as_bytes().starts_with(&text),
            "{} is no beginning of a table; choose another --out",
            place.display()
        );
        if text != head.as_bytes() {
            if text.starts_with(MARK.as_bytes()) {
                remark(format!(
                    "the rows in {} were judged by another specification and are made again",
                    place.display()
                ));
            }
            file.set_len(0).with_context(unusable)?;
            file.write_all(head.as_bytes()).with_context(unusable)?;
        }
        let mut end = head.len() as u64;
        let mut reader = BufReader::new(&file);
        reader.seek(SeekFrom::Start(end)).with_context(unusable)?;
        text.clear();
        while reader.read_until(b'\n', &mut text).with_context(unusable)? > 0 && text.ends_with(b"\n") {
            let Some((capture, axis, _)) = parsed(&text, columns) else {
                remark(format!(
                    "{} of the rows in {} are of other columns, as another version makes them, and are made again",
                    if lines.is_empty() { "all" } else { "some" },
                    place.display()
                ));
                break;
            };
            lines.insert(capture, (end, axis));
            end += text.len() as u64;
            text.clear();
        }
        file.set_len(end).with_context(unusable)?;
        Ok(Self { specification, table: table.to_owned(), place, file, lines, end })
    }

    /// Appends a row, which outlives this process from then on.
    pub(super) fn add(&mut self, capture: &CaptureFile, row: &Row) -> anyhow::Result<()> {
        let cells = row.cells().iter().map(|(_, cell)| written(cell)).collect();
        let line: Line = (capture.clone(), row.axis(), cells);
        let text = serde_json::to_string(&line)? + "\n";
        let full = || format!("{} cannot be written; free some space and run again", self.place.display());
        self.file.write_all(text.as_bytes()).with_context(full)?;
        self.lines.insert(capture.clone(), (self.end, row.axis()));
        self.end += text.len() as u64;
        Ok(())
    }

    /// Writes the table of these files in their order, and only then removes the journal; gives the number of rows with an
    /// error.
    pub(super) fn into_table(mut self, files: &[CaptureFile]) -> anyhow::Result<usize> {
        let path = self.table.clone();
        let failed = |error| ArchiveError::File { path: path.clone(), error: std::io::Error::other(error) };
        let wrong = write_whole(&path, Replace::Nothing, |place| self.write_rows(place, files).map_err(failed))?;
        std::fs::remove_file(&self.place).with_context(|| format!("{} cannot be removed", self.place.display()))?;
        Ok(wrong)
    }

    /// Writes the rows of these files; the units of the columns go into the table's key-value metadata.
    fn write_rows(&mut self, place: BufWriter<File>, files: &[CaptureFile]) -> anyhow::Result<usize> {
        let columns = Row::columns(self.specification);
        let axis = common_axis(files.iter().filter_map(|file| self.lines[file].1)).ok();
        let fields = columns.iter().map(|(name, empty)| {
            let physical = match empty {
                Cell::Text(_) => PhysicalType::BYTE_ARRAY,
                Cell::Count(_) => PhysicalType::INT64,
                Cell::Real(_) => PhysicalType::DOUBLE,
            };
            (name.as_str(), physical)
        });
        let unit = |(name, _): &(String, Cell)| {
            let on = |axis| Row::unit_of(name, self.specification, axis);
            // A column about captures of both axes has a unit if it is that of either.
            let unit = match axis {
                Some(axis) => on(axis),
                None => on(Axis::Rotary).filter(|unit| on(Axis::Linear).as_ref() == Some(unit)),
            };
            Some((format!("unit.{name}"), unit?.into_owned()))
        };
        let metadata = columns.iter().filter_map(unit).chain([software()]);
        let mut table = begin(place, "captures", fields, Repetition::OPTIONAL, metadata, WriterProperties::builder())?;
        let mut wrong = 0;
        for files in files.chunks(ROWS_AT_ONCE) {
            let rows = files.iter().map(|file| read_back(&mut self.file, self.lines[file].0, columns.len()));
            let rows = rows.collect::<anyhow::Result<Vec<_>>>()?;
            wrong += rows.iter().filter(|cells| cells[ERROR].is_some()).count();
            let mut group = table.next_row_group()?;
            for (place, (_, empty)) in columns.iter().enumerate() {
                let cells = rows.iter().map(|row| row[place].as_deref());
                match empty {
                    Cell::Text(_) => {
                        write_column::<ByteArrayType, _>(&mut group, cells.map(|text| text.map(ByteArray::from)))?;
                    }
                    Cell::Count(_) => write_column::<Int64Type, _>(&mut group, cells.map(|text| text?.parse().ok()))?,
                    Cell::Real(_) => write_column::<DoubleType, _>(&mut group, cells.map(|text| text?.parse().ok()))?,
                }
            }
            group.close()?;
        }
        table.close()?;
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

/// The file of a line and its cells, if it has so many.
fn parsed(line: &[u8], cells: usize) -> Option<Line> {
    serde_json::from_slice(line).ok().filter(|(.., there): &Line| there.len() == cells)
}

fn read_back(journal: &mut File, start: u64, cells: usize) -> anyhow::Result<Vec<Option<String>>> {
    journal.seek(SeekFrom::Start(start))?;
    let mut line = Vec::new();
    BufReader::new(journal).read_until(b'\n', &mut line)?;
    let (.., cells) = parsed(&line, cells).context("the journal was changed in the meantime; make the table again")?;
    Ok(cells)
}
