//! What can go wrong with a capture, one sentence each.

use std::path::PathBuf;

use foreign_files::TableError;

/// Why a capture could not be read, written, merged or recovered.
#[derive(Debug, thiserror::Error)]
pub enum ArchiveError {
    /// There is no such file.
    #[error("{} does not exist; check the path", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The operating system refused.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Its reason.
        error: std::io::Error,
    },
    /// A file cannot be written.
    #[error("{} cannot be written ({reason}); choose another place", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        reason: String,
    },
    /// The file holds nothing.
    #[error("{} is empty: it holds neither an MCAP archive nor a CSV table", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// The file is neither MCAP nor text.
    #[error(
        "{} is not an MCAP archive (its first bytes are not MCAP's) and not a CSV table either; save a table as UTF-8 text, or name its \
         columns, as in time=NAME,angle=NAME,torque=NAME",
        path.display()
    )]
    NotACapture {
        /// The file.
        path: PathBuf,
    },
    /// An MCAP file ends too early.
    #[error(
        "{path} ends in the middle (was its recorder killed?): run `haptic-camera recover {path} --out FIXED.mcap`",
        path = path.display()
    )]
    Truncated {
        /// The file.
        path: PathBuf,
    },
    /// An MCAP file contradicts its own checksums or structure.
    #[error(
        "{path} is damaged ({reason}): run `haptic-camera recover {path} --out FIXED.mcap`",
        path = path.display()
    )]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// An MCAP file without our samples.
    #[error("{} is an MCAP archive without a channel `/sample` of `ros2msg` CDR messages, so it is not a capture", path.display())]
    NoSamples {
        /// The file.
        path: PathBuf,
    },
    /// The samples lack a field without which there is no capture.
    #[error("{} stores samples without the field `{field}`; it has: {found}", path.display())]
    MissingField {
        /// The file.
        path: PathBuf,
        /// The field that a capture must have.
        field: &'static str,
        /// The fields that are there.
        found: String,
    },
    /// The schema in the file is not understood.
    #[error("{}: the schema of its samples cannot be read: {error}", path.display())]
    Schema {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: crate::schema::SchemaError,
    },
    /// The archive does not say at which rate it was sampled.
    #[error("{} has no sample rate: it contains neither `run.json` nor the metadata record `capture`", path.display())]
    NoRate {
        /// The file.
        path: PathBuf,
    },
    /// The table is not one of a capture.
    #[error("{}: {error}{}", path.display(), remedy(error))]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and in which line.
        error: TableError,
    },
    /// The table of a tester has no known format.
    #[error(
        "{} is not a known table: it has {columns}; name its columns, as in travel=NAME,force=NAME, and their units, as \
         in travel=mm,force=gf",
        path.display()
    )]
    UnknownTable {
        /// The file.
        path: PathBuf,
        /// The columns that it has, in words.
        columns: String,
    },
    /// The file of a tester cannot be read.
    #[error("{}: {reason}", path.display())]
    Tester {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The file of a tester has no time, which a capture must have.
    #[error(
        "{} has no time, so it is a curve and not a capture: only `fit`, `compare`, `sheet`, `judge`, \
         `capability` and `gauge` accept it, by the names of its columns, as in angle=NAME,torque=NAME; if it has a time, add time=NAME",
        path.display()
    )]
    NoTime {
        /// The file.
        path: PathBuf,
    },
    /// A value is NaN or infinite.
    #[error("{}, row {row}: {column} is {value}; a capture holds finite numbers only", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// Row, counted from 1.
        row: usize,
        /// The column.
        column: &'static str,
        /// The value.
        value: f64,
    },
    /// Time does not increase.
    #[error(
        "{}, row {row}: t_s = {time_s} s comes after {previous_s} s; time must increase from row to row: sort the rows, leave \
         repeated ones out, and write times with more digits where they are rounded",
        path.display()
    )]
    Unordered {
        /// The file.
        path: PathBuf,
        /// Row, counted from 1.
        row: usize,
        /// Its time, s.
        time_s: f64,
        /// The time of the row before, s.
        previous_s: f64,
    },
    /// Too few samples to be a capture.
    #[error("{} has {rows}; a capture needs at least three", path.display(), rows = rows_in_words(*rows))]
    TooShort {
        /// The file.
        path: PathBuf,
        /// Rows that it has.
        rows: usize,
    },
    /// There is not enough memory for the file.
    #[error(
        "{} has {:.1} GB and needs {:.1} GB of memory, of which {:.1} GB are free; use a machine with more, or \
         capture for at most {:.0} % of that time",
        path.display(), length / 1e9, needed / 1e9, available / 1e9, (100.0 * available / needed).floor()
    )]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its length, bytes.
        length: f64,
        /// Memory that it takes, bytes.
        needed: f64,
        /// Memory that is free, bytes.
        available: f64,
    },
    /// The columns of a capture in memory differ in length.
    #[error("the column {column} has {rows} rows, but angle_rad has {expected}")]
    Ragged {
        /// The column.
        column: &'static str,
        /// Its rows.
        rows: usize,
        /// The rows of the angle.
        expected: usize,
    },
    /// Two rows of a capture in memory fall on one tick.
    #[error("row {row} falls on the same tick as the row before at {rate_hz} Hz: the samples are not evenly spaced")]
    SharedTick {
        /// Row, counted from 1.
        row: usize,
        /// The rate, Hz.
        rate_hz: f64,
    },
    /// MCAP could not be written.
    #[error("the archive could not be written: {reason}")]
    Write {
        /// What mcap or the operating system said.
        reason: String,
    },
    /// Nothing in the file could be kept.
    #[error("{} has nothing to recover: no complete MCAP record with a valid checksum", path.display())]
    NothingToRecover {
        /// The file.
        path: PathBuf,
    },
    /// Output and input are one file.
    #[error("{} is both the broken archive and the output; choose another name for the output", path.display())]
    SameFile {
        /// The file.
        path: PathBuf,
    },
    /// There is something that an output must not take the place of.
    #[error("{} is {by}; choose another name, or remove it first", path.display())]
    Occupied {
        /// The place.
        path: PathBuf,
        /// What it is.
        by: &'static str,
    },
    /// A part belongs to another run.
    #[error("{} belongs to run {found:016x}, not to run {expected:016x}; merge the parts of one run only", path.display())]
    OtherRun {
        /// The part.
        path: PathBuf,
        /// Its run.
        found: u64,
        /// The run of the first part.
        expected: u64,
    },
    /// No parts were given.
    #[error("there are no parts to merge into {}", path.display())]
    NoParts {
        /// The place for the whole archive.
        path: PathBuf,
    },
}

/// What to do about a table of other columns.
fn remedy(error: &TableError) -> &'static str {
    match error {
        TableError::Header { .. } => "; name other columns, as in time=NAME,angle=NAME,torque=NAME",
        _ => "",
    }
}

impl ArchiveError {
    /// The operating system's refusal of `path`.
    pub(crate) fn file(path: &std::path::Path, error: std::io::Error) -> Self {
        if error.kind() == std::io::ErrorKind::NotFound {
            Self::Missing { path: path.to_owned() }
        } else {
            Self::File { path: path.to_owned(), error }
        }
    }

    /// What is wrong with the table at `path`.
    pub(crate) fn table(path: &std::path::Path, error: TableError) -> Self {
        match error {
            TableError::NotText => Self::NotACapture { path: path.to_owned() },
            TableError::System { kind, reason } => Self::file(path, std::io::Error::new(kind, reason)),
            error => Self::Table { path: path.to_owned(), error },
        }
    }

    /// A failure to write, with every cause that mcap knows of.
    pub(crate) fn write(error: &(dyn std::error::Error + 'static)) -> Self {
        Self::Write { reason: with_causes(error) }
    }
}

/// An error and what caused it, in one line.
pub(crate) fn with_causes(error: &(dyn std::error::Error + 'static)) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(inner) = cause {
        text = format!("{text}: {inner}");
        cause = inner.source();
    }
    text
}

fn rows_in_words(rows: usize) -> String {
    match rows {
        0 => "no rows".to_owned(),
        1 => "one row".to_owned(),
        2 => "two rows".to_owned(),
        more => format!("{more} rows"),
    }
}
