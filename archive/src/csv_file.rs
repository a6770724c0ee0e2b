//! Captures as CSV tables.

use std::io::Write;
use std::path::Path;

use foreign_files::{Column, OtherColumns, read_columns};
use shared_types::Axis;

use crate::capture::{Capture, first_bytes};
use crate::columns::{self, MEASURED, Values};
use crate::error::ArchiveError;

/// Reads a table; its columns may stand in any order.
pub(crate) fn load(path: &Path) -> Result<Capture, ArchiveError> {
    let axis = axis_of(path)?.unwrap_or_default();
    let file = foreign_files::open(path).map_err(|error| ArchiveError::file(path, error))?;
    let wanted = MEASURED.each_ref().map(|column| match column.required {
        true => Column::required(column.name_on(axis)),
        false => Column::optional(column.name_on(axis)),
    });
    let found = read_columns(file, wanted, OtherColumns::Refused).map_err(|error| ArchiveError::table(path, error))?;
    let mut capture = Capture { source: path.to_owned(), axis, ..Capture::default() };
    for (column, values) in MEASURED.iter().zip(found) {
        if let Some(values) = values {
            (column.store)(&mut capture, Values::Reals(values.into()));
        }
    }
    // A program writes as many decimals as it was told to.
    if let Some(even_s) = dynamics::even_times(&capture.t_s) {
        capture.t_s = even_s;
    }
    count(&mut capture);
    Ok(capture)
}

/// Sets rate, `seq` and ticks from the times of the rows.
pub(crate) fn count(capture: &mut Capture) {
    capture.rate_hz = rate_hz(&capture.t_s);
    capture.seq = (0..capture.t_s.len() as u64).collect();
    capture.tick = ticks(&capture.t_s, capture.rate_hz);
}

/// Bytes at the beginning of a table that hold the names of all columns.
const HEADER: usize = 4096;

/// The axis whose names of all required columns stand in one line; `None` if there is no such line.
pub(crate) fn axis_of(path: &Path) -> Result<Option<Axis>, ArchiveError> {
    let head = first_bytes(path, HEADER)?;
    let has_all = |axis: &Axis| {
        let required = MEASURED.iter().filter(|column| column.required).map(|column| column.name_on(*axis));
        foreign_files::preamble(&head, &required.collect::<Vec<_>>()).is_some()
    };
    Ok([Axis::Rotary, Axis::Linear].into_iter().find(has_all))
}

/// The rate of a table, Hz: the number of ticks divided by the whole time span. The median interval is the first estimate of a tick.
///
/// Times in tables are rounded, which is negligible over the whole span. The rate is 0 if time does not rise; validation refuses such
/// a table.
fn rate_hz(t_s: &[f64]) -> f64 {
    let (Some(first), Some(last)) = (t_s.first(), t_s.last()) else {
        return 0.0;
    };
    let mut intervals: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    let Some(&median) = intervals.get(intervals.len() / 2) else {
        return 0.0;
    };
    // Each interval is rounded to whole ticks by itself: the median's rounding error does not accumulate. The second pass is for long gaps.
    let rate = [(); 2].iter().fold(1.0 / median, |rate, ()| {
        let ticks: f64 = intervals.iter().map(|interval| (interval * rate).round()).sum();
        ticks / (last - first)
    });
    // Tables are written at rates that are whole numbers more often than not.
    let round = rate.round();
    if (rate - round).abs() < 1e-5 * round { round } else { rate }
}

fn ticks(t_s: &[f64], rate_hz: f64) -> Vec<u64> {
    let start = t_s.first().copied().unwrap_or_default();
    t_s.iter().map(|time| ((time - start) * rate_hz).round() as u64).collect()
}

/// Writes a table with the columns that the capture has.
pub(crate) fn write(capture: &Capture, place: impl Write) -> Result<(), ArchiveError> {
    let columns = columns::measured(capture);
    let mut table = csv::Writer::from_writer(place);
    table.write_record(columns.iter().map(|(name, _)| *name)).map_err(|error| ArchiveError::write(&error))?;
    for row in 0..capture.len() {
        table
            .write_record(columns.iter().map(|(_, column)| column[row].to_string()))
            .map_err(|error| ArchiveError::write(&error))?;
    }
    table.flush().map_err(|error| ArchiveError::write(&error))
}
