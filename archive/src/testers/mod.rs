//! Curves that other people's testers measured: load over position, turned or pressed.
//!
//! Known are the files of the Open-Switch-Curve-Meter, IMADA's Force Recorder (both of its exports), automotive button benches,
//! tables with the two columns `force` and `displacement`, JSON with `down_x`, `down_y`, `up_x` and `up_y`, and tables with our
//! own column names but without a time. A [`ColumnChoice`] says what any other table holds. Measurements in ASAM MDF 4 have their
//! channels' names and units in them.
//!
//! A format is one entry of `FORMATS`: it looks at a table and says in which columns and units everything lies.

mod choice;
mod formats;
mod json;
mod layout;
mod mdf;
mod separator;
mod table;

use std::path::{Path, PathBuf};

use shared_types::Axis;

pub use choice::{Assignments, ChoiceError, ColumnChoice};
pub(crate) use mdf::is_mdf;

use crate::capture::{Capture, is_mcap, refuse_too_large};
use crate::error::ArchiveError;
use crate::memory;
use table::RawTable;

/// Fewest rows that make a curve.
const FEWEST_ROWS: usize = 16;

/// Load over position, row by row as it was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Where it was read from.
    pub source: PathBuf,
    /// Whether the control was turned or pressed, and so the units of the columns.
    pub axis: Axis,
    /// Time, s; `None` of a quasi-static curve, in which time has no part.
    pub t_s: Option<Vec<f64>>,
    /// Whether the time is that of a capture of motion: its column was chosen, or is called as ours.
    pub is_of_motion: bool,
    /// Angle in rad, or travel in mm.
    pub position: Vec<f64>,
    /// Torque in mNm, or force in N, that the control takes from whoever moves it.
    pub load: Vec<f64>,
    /// Whether the contact was closed; `None` where it was not watched, or never closed.
    pub closed: Option<Vec<bool>>,
}

impl Curve {
    /// The curves from which the figures of one part are read: turns are joined, since a longer curve determines the figures better;
    /// presses stay separate, as testers read them.
    #[must_use]
    pub fn evidence(curves: &[Self]) -> Vec<Self> {
        let mut all = curves.iter().cloned();
        let Some(mut whole) = all.next().filter(|curve| curve.axis == Axis::Rotary) else { return curves.to_vec() };
        for curve in all {
            let before_s = whole.t_s.as_ref().and_then(|t_s| t_s.last().copied()).unwrap_or(0.0);
            if let (Some(t_s), Some(more)) = (&mut whole.t_s, &curve.t_s) {
                let step_s = more.get(1).copied().unwrap_or(0.0) - more.first().copied().unwrap_or(0.0);
                t_s.extend(more.iter().map(|time_s| before_s + step_s + time_s));
            }
            whole.position.extend(&curve.position);
            whole.load.extend(&curve.load);
        }
        vec![whole]
    }

    /// Reads a tester's file, with the columns as chosen or as its format has them.
    ///
    /// # Errors
    /// [`ArchiveError`]: one sentence, which says what columns the file has if it is none of the known ones.
    pub fn load(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Self, ArchiveError> {
        refuse_too_large(path, if is_mdf(path)? { 0.0 } else { memory::OF_FOREIGN_ROW })?;
        if is_mcap(path)? {
            return Err(wrong(path, "it is an MCAP archive, whose columns have fixed names".to_owned()));
        }
        let mut curve = if is_mdf(path)? {
            Self { is_of_motion: true, ..mdf::read(path, chosen)? }
        } else if json::is_json(path)? {
            if chosen.is_some() {
                let reason = "it is JSON, whose lists have fixed names and units; choose no columns".to_owned();
                return Err(wrong(path, reason));
            }
            json::read(path)?
        } else {
            let table = RawTable::read(path)?;
            let layout = match chosen {
                Some(chosen) => chosen.layout(&table).map_err(|error| wrong(path, error.to_string()))?,
                None => formats::recognise(&table)
                    .ok_or_else(|| ArchiveError::UnknownTable { path: path.to_owned(), columns: table.columns() })?,
            };
            let curve = layout.read(&table).map_err(|reason| wrong(path, reason))?;
            Curve { is_of_motion: table.place("t_s").is_some(), ..curve }
        };
        curve.is_of_motion = curve.t_s.is_some() && (curve.is_of_motion || chosen.is_some());
        curve.source = path.to_owned();
        curve.check()
    }

    /// The curve as a capture, whose rows are counted where there is no time.
    ///
    /// # Errors
    /// What [`Capture::validate`] reports.
    pub fn into_capture(self) -> Result<Capture, ArchiveError> {
        let counted = || (0..self.position.len()).map(|row| row as f64).collect();
        Capture::from_measured(Capture {
            source: self.source,
            axis: self.axis,
            t_s: self.t_s.unwrap_or_else(counted),
            angle_rad: self.position,
            torque_mnm: self.load,
            contact: self.closed.map(|closed| closed.into_iter().map(|closed| f64::from(u8::from(closed))).collect()),
            ..Capture::default()
        })
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// True without any row; a curve that was loaded never is.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    fn check(self) -> Result<Self, ArchiveError> {
        let rows = self.len();
        if rows < FEWEST_ROWS {
            return Err(wrong(&self.source, format!("it has {rows} rows; a curve needs at least {FEWEST_ROWS}")));
        }
        let first = self.position[0];
        if self.position.iter().all(|position| (position - first).abs() < f64::EPSILON) {
            let what = self.axis.position().name();
            return Err(wrong(&self.source, format!("its {what} never changes, so there is no curve")));
        }
        Ok(self)
    }
}

fn wrong(path: &Path, reason: String) -> ArchiveError {
    ArchiveError::Tester { path: path.to_owned(), reason }
}
