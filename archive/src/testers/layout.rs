//! In which columns and units everything of a table lies.

use shared_types::Axis;

use super::Curve;
use super::table::RawTable;

/// Share of the voltage's range that must lie between the mean levels of open and closed contact for the voltage to tell them apart.
const CLEAR: f64 = 0.5;
/// Seconds in an hour, after which clocks begin anew.
const HOUR_S: f64 = 3600.0;

/// A column with the size of its unit in ours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Source {
    pub(super) column: usize,
    pub(super) factor: f64,
}

/// How a table tells the time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Time {
    /// Not at all: the curve is quasi-static.
    None,
    /// In a column.
    Column(Source),
    /// In a column of minutes, seconds and fractions, with points between them.
    Clock(usize),
    /// By the interval from row to row, s.
    EachRow(f64),
}

/// How a table tells whether the contact is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Contact {
    /// By the voltage over the contact, which falls as the contact closes. A column of nothing but 0 and 1 is read as a flag.
    Voltage(usize),
    /// By a flag.
    Flag(usize),
}

/// Where everything is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) axis: Axis,
    pub(super) position: Source,
    pub(super) load: Source,
    pub(super) time: Time,
    pub(super) contact: Option<Contact>,
}

impl Layout {
    /// Takes the columns out of the table.
    ///
    /// # Errors
    /// A sentence about the cell that is no number, or the time that does not rise.
    pub(super) fn read(&self, table: &RawTable) -> Result<Curve, String> {
        if let Some(line) = table.parted_row() {
            return Err(format!(
                "line {line}: it has more cells than the header: name every column, and write numbers with a point, as in 1.5"
            ));
        }
        let of = |source: Source| table.column(source.column, source.factor);
        let t_s = match self.time {
            Time::None => None,
            Time::Column(source) => {
                let t_s = if is_dated(table, source.column) { dated_s(table, source.column)? } else { of(source)? };
                Some(dynamics::even_times(&t_s).unwrap_or(t_s))
            }
            Time::Clock(column) => {
                Some(unwrapped(table.cells(column, clock_s, "a time as minutes.seconds.fraction")?))
            }
            Time::EachRow(interval_s) => Some((0..table.rows.len()).map(|row| row as f64 * interval_s).collect()),
        };
        refuse_falling(t_s.as_deref())?;
        let closed = match self.contact {
            Some(Contact::Voltage(column)) => closed(&table.levels(column)?),
            Some(Contact::Flag(column)) => flagged(&table.levels(column)?),
            None => None,
        };
        Ok(Curve {
            axis: self.axis,
            t_s,
            position: of(self.position)?,
            load: of(self.load)?,
            closed,
            ..Curve::default()
        })
    }
}

/// Refuses a time that runs backwards.
///
/// # Errors
/// A sentence about the first row that lies before the one above it.
pub(super) fn refuse_falling(t_s: Option<&[f64]>) -> Result<(), String> {
    match t_s.and_then(|t_s| t_s.windows(2).position(|pair| pair[1] < pair[0])) {
        Some(row) => Err(format!(
            "row {}: its time is before that of the row above; sort the rows, or cut the file where its clock began anew",
            row + 2
        )),
        None => Ok(()),
    }
}

/// Whether a column's first cell is a date and time.
fn is_dated(table: &RawTable, column: usize) -> bool {
    table.rows.first().and_then(|row| row.get(column)).is_some_and(|cell| date(cell).is_some())
}

/// A column of dates and times (ISO 8601), as s since the first.
fn dated_s(table: &RawTable, column: usize) -> Result<Vec<f64>, String> {
    let dates = table.cells(column, date, "a date and time, as the first is")?;
    Ok(dates.iter().map(|date| date.duration_since(dates[0]).as_secs_f64()).collect())
}

/// A moment; without a zone, in universal time.
fn date(cell: &str) -> Option<jiff::Timestamp> {
    // A number alone is no date.
    if !(cell.contains('-') && cell.contains(':')) {
        return None;
    }
    let in_no_zone = || cell.parse::<jiff::civil::DateTime>().ok()?.to_zoned(jiff::tz::TimeZone::UTC).ok();
    cell.parse().ok().or_else(|| Some(in_no_zone()?.timestamp()))
}

/// Minutes, seconds and fractions of a second as s.
fn clock_s(text: &str) -> Option<f64> {
    let (minutes, seconds) = text.split_once('.')?;
    Some(60.0 * minutes.trim().parse::<f64>().ok()? + seconds.trim().parse::<f64>().ok()?)
}

/// Times from zero on, where the clock begins anew each hour.
fn unwrapped(clock_s: Vec<f64>) -> Vec<f64> {
    let first = clock_s.first().copied().unwrap_or_default();
    let mut hours = 0.0;
    let mut before = first;
    let onwards = clock_s.into_iter().map(|now| {
        if now < before - 0.5 * HOUR_S {
            hours += 1.0;
        }
        before = now;
        now - first + hours * HOUR_S
    });
    onwards.collect()
}

/// Where a flag says that the contact is closed; `None` where it never does.
fn flagged(flag: &[f64]) -> Option<Vec<bool>> {
    let closed: Vec<bool> = flag.iter().map(|flag| *flag != 0.0).collect();
    closed.contains(&true).then_some(closed)
}

/// Where a voltage, or a flag of 0 and 1, says that the contact is closed; `None` where it tells nothing.
pub(super) fn closed(values: &[f64]) -> Option<Vec<bool>> {
    let is_flag = values.iter().all(|value| *value == 0.0 || *value == 1.0);
    if is_flag { flagged(values) } else { below_middle(values) }
}

/// Where a voltage with two levels is at the lower one; `None` where it has no two levels.
fn below_middle(voltage: &[f64]) -> Option<Vec<bool>> {
    let (low, high) =
        voltage.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)));
    let middle = 0.5 * (low + high);
    let mean = |keep: &dyn Fn(f64) -> bool| {
        let kept = voltage.iter().copied().filter(|v| keep(*v));
        let (sum, count) = kept.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
        sum / count
    };
    let levels_apart = mean(&|v| v >= middle) - mean(&|v| v < middle);
    (levels_apart > CLEAR * (high - low)).then(|| voltage.iter().map(|v| *v < middle).collect())
}
