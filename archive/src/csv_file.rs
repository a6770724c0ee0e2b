//! Captures as CSV tables.

use std::io::Write;
use std::path::Path;

use crate::capture::Capture;
use crate::error::ArchiveError;

const TIME: &str = "t_s";
const ANGLE: &str = "angle_rad";
const VELOCITY: &str = "velocity_rad_s";
const ACCELERATION: &str = "acceleration_rad_s2";
const TORQUE: &str = "torque_mnm";
/// Every column a table can have, in the order in which one is written.
const COLUMNS: [&str; 5] = [TIME, ANGLE, VELOCITY, ACCELERATION, TORQUE];

/// Reads a table; its columns may stand in any order.
pub(crate) fn load(path: &Path) -> Result<Capture, ArchiveError> {
    let file = std::fs::File::open(path).map_err(|error| ArchiveError::file(path, error))?;
    let mut table = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = table.headers().map_err(|error| not_a_row(path, 0, &error))?.clone();
    let names: Vec<&str> = header.iter().map(|name| name.trim_start_matches('\u{feff}').trim()).collect();
    let mut columns = known_columns(path, &names)?;
    let mut record = csv::StringRecord::new();
    let mut row = 0;
    while table.read_record(&mut record).map_err(|error| not_a_row(path, row + 1, &error))? {
        row += 1;
        for (cell, (name, values)) in record.iter().zip(&mut columns) {
            let value = cell.parse::<f64>().map_err(|_| ArchiveError::BadRow {
                path: path.to_owned(),
                row,
                reason: format!("`{cell}` in the column {name} is not a number"),
            })?;
            values.push(value);
        }
    }
    let mut take = |wanted: &str| {
        let place = columns.iter().position(|(name, _)| *name == wanted)?;
        Some(columns.swap_remove(place).1)
    };
    let t_s = take(TIME).unwrap_or_default();
    let mut capture = Capture {
        source: path.to_owned(),
        angle_rad: take(ANGLE).unwrap_or_default(),
        velocity_rad_s: take(VELOCITY),
        acceleration_rad_s2: take(ACCELERATION),
        torque_mnm: take(TORQUE).unwrap_or_default(),
        rate_hz: rate_hz(&t_s),
        seq: (0..t_s.len() as u64).collect(),
        ..Capture::default()
    };
    capture.tick = ticks(&t_s, capture.rate_hz);
    capture.t_s = t_s;
    Ok(capture)
}

/// Checks the header; each column with its name, still empty.
fn known_columns(path: &Path, names: &[&str]) -> Result<Vec<(&'static str, Vec<f64>)>, ArchiveError> {
    let columns: Vec<&'static str> =
        names.iter().filter_map(|name| COLUMNS.into_iter().find(|known| known == name)).collect();
    let complete = [TIME, ANGLE, TORQUE].iter().all(|name| columns.contains(name));
    let repeats = columns.iter().enumerate().any(|(index, name)| columns[..index].contains(name));
    if !complete || repeats || columns.len() != names.len() {
        return Err(ArchiveError::WrongHeader { path: path.to_owned(), found: short(&names.join(",")) });
    }
    Ok(columns.into_iter().map(|name| (name, Vec::new())).collect())
}

/// A header that is no header can be a whole file: show its beginning.
fn short(header: &str) -> String {
    const SHOWN: usize = 200;
    let mut text: String = header.chars().filter(|character| !character.is_control()).take(SHOWN).collect();
    if header.chars().count() > SHOWN {
        text.push_str("...");
    }
    text
}

fn not_a_row(path: &Path, row: usize, error: &csv::Error) -> ArchiveError {
    if let csv::ErrorKind::UnequalLengths { expected_len, len, .. } = error.kind() {
        let reason = format!("it has {len} cells, but the header has {expected_len}");
        return ArchiveError::BadRow { path: path.to_owned(), row, reason };
    }
    if let csv::ErrorKind::Utf8 { .. } = error.kind() {
        return ArchiveError::NotACapture { path: path.to_owned() };
    }
    ArchiveError::BadRow { path: path.to_owned(), row, reason: crate::error::with_causes(error) }
}

/// The rate of a table, Hz: ticks over the whole span, where the median interval says what a tick is.
///
/// Times in tables are rounded; over the whole span that no longer matters. 0 when time does not
/// rise, which validation refuses.
fn rate_hz(t_s: &[f64]) -> f64 {
    let (Some(first), Some(last)) = (t_s.first(), t_s.last()) else {
        return 0.0;
    };
    let mut intervals: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    let Some(&median) = intervals.get(intervals.len() / 2) else {
        return 0.0;
    };
    // Interval by interval, so that the median's rounding does not add up; twice, for long gaps.
    let rate = [(); 2].iter().fold(1.0 / median, |rate, ()| {
        let ticks: f64 = intervals.iter().map(|interval| (interval * rate).round()).sum();
        ticks / (last - first)
    });
    // Tables are written at rates that are whole numbers more often than not.
    let round = rate.round();
    if (rate - round).abs() < 1e-5 * round { round } else { rate }
}

#[allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a negative or absurd time saturates, and validation has its word"
)]
fn ticks(t_s: &[f64], rate_hz: f64) -> Vec<u64> {
    // A table may begin before its zero of time; ticks cannot.
    let start = t_s.first().map_or(0.0, |&first| first.min(0.0));
    t_s.iter().map(|time| ((time - start) * rate_hz).round() as u64).collect()
}

/// Writes a table with the columns that the capture has.
pub(crate) fn write(capture: &Capture, place: impl Write) -> Result<(), ArchiveError> {
    let columns: Vec<(&str, &Vec<f64>)> = [
        Some(&capture.t_s),
        Some(&capture.angle_rad),
        capture.velocity_rad_s.as_ref(),
        capture.acceleration_rad_s2.as_ref(),
        Some(&capture.torque_mnm),
    ]
    .into_iter()
    .zip(COLUMNS)
    .filter_map(|(column, name)| Some((name, column?)))
    .collect();
    let mut table = csv::Writer::from_writer(place);
    table.write_record(columns.iter().map(|(name, _)| *name)).map_err(|error| ArchiveError::write(&error))?;
    for row in 0..capture.len() {
        table
            .write_record(columns.iter().map(|(_, column)| column[row].to_string()))
            .map_err(|error| ArchiveError::write(&error))?;
    }
    table.flush().map_err(|error| ArchiveError::write(&error))
}
