//! A capture in memory: one column per quantity, from an MCAP archive, a CSV table or an ASAM MDF file.

use std::collections::BTreeMap;
use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

use shared_types::{Axis, ModelChange, RunDescription, Sample};

use crate::description::attachment;
use crate::error::ArchiveError;
use crate::rig_account::RigAccount;
use crate::sequence::Gap;
use crate::testers::{ColumnChoice, Curve, is_mdf};
use crate::whole_file::{self, Replace};
use crate::write::CaptureWriter;
use crate::{columns, csv_file, mcap_file, memory};

/// A capture, row by row in the order of time. All columns have the same length, at least three.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Capture {
    /// Where it was read from; empty for one made in memory.
    pub source: PathBuf,
    /// Whether the control was turned. If it was pressed or slid, columns named for rad hold mm, and columns named for mNm hold N.
    pub axis: Axis,
    /// Sample rate, Hz: as described in an archive, from the median interval of a table.
    pub rate_hz: f64,
    /// Number of each sample in its run; rows of a table are counted from 0.
    pub seq: Vec<u64>,
    /// Scheduled tick of each sample; jumps where ticks were missed or samples lost.
    pub tick: Vec<u64>,
    /// State of the control loop at each sample, see [`shared_types::LoopState`]; `None` from a table.
    pub state: Option<Vec<u32>>,
    /// Ticks that the loop missed directly before each sample; `None` from a table.
    pub missed_ticks: Option<Vec<u32>>,
    /// Bits of [`Sample::flags`] of each sample; `None` from a table.
    pub flags: Option<Vec<u32>>,
    /// Why the loop stopped, at each sample, as [`Sample::fault`]; `None` from a table.
    pub fault: Option<Vec<u32>>,
    /// Bits of the rig's own code at each sample, [`Sample::device_code`]; `None` from a table.
    pub device_code: Option<Vec<u32>>,
    /// Time since the start of the run, s: tick / rate and what the rig was late by, or as the table gives it.
    pub t_s: Vec<f64>,
    /// Encoder angle, rad.
    pub angle_rad: Vec<f64>,
    /// Angular velocity, rad/s.
    pub velocity_rad_s: Option<Vec<f64>>,
    /// Angular acceleration, rad/s^2.
    pub acceleration_rad_s2: Option<Vec<f64>>,
    /// Torque that the knob takes from the rig, mNm.
    pub torque_mnm: Vec<f64>,
    /// Whether the control's contact was closed: 1, or 0; `None` where nobody watched one.
    pub contact: Option<Vec<f64>>,
    /// Angle that the excitation asked for, rad; NaN where it asked for none.
    pub commanded_angle_rad: Option<Vec<f64>>,
    /// Torque commanded from the motor, mNm; NaN where it is unknown.
    pub commanded_torque_mnm: Option<Vec<f64>>,
    /// How long after its tick was due each sample was read, s; `None` where all were read when they were due.
    pub measured_after_s: Option<Vec<f64>>,
    /// Samples in the archive without a measurement of their own, since the sensors delivered no new data or failed, in the order of
    /// `seq`; the columns leave them out.
    pub unmeasured: Vec<Sample>,
    /// How the rig kept up with the ticks.
    pub rig: RigAccount,
    /// Samples that were taken and are not in the archive.
    pub gaps: Vec<Gap>,
    /// The models that a replay rendered, in the order in which they began to be felt; empty for a capture of a knob.
    pub models: Vec<ModelChange>,
    /// The run's description; `None` from a table.
    pub description: Option<RunDescription>,
    /// Metadata records of the archive by name.
    pub metadata: BTreeMap<String, BTreeMap<String, String>>,
    /// Attachments of the archive by name, see [`attachment`].
    pub attachments: BTreeMap<String, Vec<u8>>,
}

impl Capture {
    /// Reads an MCAP archive, a CSV table or an ASAM MDF measurement; the content tells which of them it is.
    ///
    /// # Errors
    /// [`ArchiveError`], one sentence that names file, row and column where there is one.
    pub fn load(path: &Path) -> Result<Self, ArchiveError> {
        Self::load_chosen(path, None)
    }

    /// [`load`](Self::load) for a table or a measurement whose columns were chosen; an archive's need no choice.
    ///
    /// # Errors
    /// As [`load`](Self::load), and [`ArchiveError::NoTime`] for one without a time.
    pub fn load_chosen(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Self, ArchiveError> {
        if chosen.is_some() && !is_mcap(path)? || is_mdf(path)? {
            let curve = Curve::load(path, chosen)?;
            let has_time = curve.t_s.is_some();
            return if has_time { curve.into_capture() } else { Err(ArchiveError::NoTime { path: path.to_owned() }) };
        }
        let is_archive = is_mcap(path)?;
        refuse_too_large(path, if is_archive { 0.0 } else { memory::OF_ROW })?;
        let capture = if is_archive { mcap_file::load(path)? } else { csv_file::load(path)? };
        capture.validate()?;
        Ok(capture)
    }

    /// Whether a file is an archive, whose columns have fixed names.
    ///
    /// # Errors
    /// [`ArchiveError`] for a file that cannot be read.
    pub fn is_archive(path: &Path) -> Result<bool, ArchiveError> {
        is_mcap(path)
    }

    /// Whether a file is an archive, an ASAM MDF measurement, or a table with the columns of a capture and a time.
    ///
    /// # Errors
    /// [`ArchiveError`] for a file that cannot be read.
    pub fn is_one(path: &Path) -> Result<bool, ArchiveError> {
        Ok(is_mcap(path)? || is_mdf(path)? || csv_file::axis_of(path)?.is_some())
    }

    /// A capture of evenly spaced samples from tick 0 on.
    #[must_use]
    pub fn from_columns(rate_hz: f64, angle_rad: Vec<f64>, torque_mnm: Vec<f64>) -> Self {
        let tick: Vec<u64> = (0..angle_rad.len() as u64).collect();
        let t_s = tick.iter().map(|&tick| tick as f64 / rate_hz).collect();
        Self { rate_hz, seq: tick.clone(), tick, t_s, angle_rad, torque_mnm, ..Self::default() }
    }

    /// A capture of measured columns alone, as a table holds them: rate and ticks follow from the times.
    ///
    /// # Errors
    /// What [`validate`](Self::validate) reports.
    pub fn from_measured(mut measured: Self) -> Result<Self, ArchiveError> {
        measured.check_rows(columns::measured(&measured).iter().map(|(column, values)| (*column, values.len())))?;
        csv_file::count(&mut measured);
        measured.validate()?;
        Ok(measured)
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.angle_rad.len()
    }

    /// True without any row; a capture that was loaded never is.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.angle_rad.is_empty()
    }

    /// How many samples have no measurement of their own.
    #[must_use]
    pub fn unmeasured_samples(&self) -> u64 {
        self.unmeasured.len() as u64
    }

    /// Whether the rig rendered a model and a hand turned the gripper. Where the run's description was lost, the models tell.
    #[must_use]
    pub fn is_rendered(&self) -> bool {
        !self.models.is_empty() || self.description.as_ref().is_some_and(RunDescription::is_rendered)
    }

    /// The capture with the torque that the knob takes, whoever drives it. In a rendering, that is minus the sensor's reading; the
    /// calibration to use is the one seen from the hand.
    #[must_use]
    pub fn of_knob(mut self) -> Self {
        if self.is_rendered() {
            self.torque_mnm.iter_mut().for_each(|torque_mnm| *torque_mnm = -*torque_mnm);
        }
        self
    }

    /// From the first tick to the last, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        let ends = self.tick.first().zip(self.tick.last());
        ends.map_or(0.0, |(first, last)| last.saturating_sub(*first) as f64 / self.rate_hz)
    }

    /// Ticks between the first row and the last at which there is no row, whatever the reason.
    #[must_use]
    pub fn ticks_without_sample(&self) -> u64 {
        self.tick.windows(2).map(|pair| pair[1].saturating_sub(pair[0]).saturating_sub(1)).sum()
    }

    /// Samples that were taken and are not in the archive.
    #[must_use]
    pub fn lost_samples(&self) -> u64 {
        let listed = || self.gaps.iter().map(|gap| gap.count).sum();
        mcap_file::recorded_losses(&self.metadata).unwrap_or_else(listed)
    }

    /// Ticks before the last row that the loop missed: those without a row, but for samples that were lost or not measured.
    #[must_use]
    pub fn missed_tick_count(&self) -> u64 {
        let first_tick = self.tick.first().copied().unwrap_or(0);
        (first_tick + self.ticks_without_sample()).saturating_sub(self.lost_samples() + self.unmeasured_samples())
    }

    /// Name of the capture's file, without its folder.
    #[must_use]
    pub fn file_name(&self) -> String {
        self.source.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }

    /// The attachment of that name, as text.
    #[must_use]
    pub fn attached_text(&self, name: &str) -> Option<&str> {
        std::str::from_utf8(self.attachments.get(name)?).ok()
    }

    /// Checks what every capture promises: equal columns, three rows, finite values, rising time.
    ///
    /// # Errors
    /// [`ArchiveError::Ragged`], [`ArchiveError::TooShort`], [`ArchiveError::NotFinite`] or
    /// [`ArchiveError::Unordered`].
    pub fn validate(&self) -> Result<(), ArchiveError> {
        let rows = self.len();
        self.check_rows(columns::lengths(self))?;
        if rows < 3 {
            return Err(ArchiveError::TooShort { path: self.source.clone(), rows });
        }
        let measured = columns::measured(self);
        for row in 0..rows {
            for (column, values) in &measured {
                let value = values[row];
                if !value.is_finite() {
                    return Err(ArchiveError::NotFinite { path: self.source.clone(), row: row + 1, column, value });
                }
            }
            if row > 0 && self.t_s[row] <= self.t_s[row - 1] {
                return Err(ArchiveError::Unordered {
                    path: self.source.clone(),
                    row: row + 1,
                    time_s: self.t_s[row],
                    previous_s: self.t_s[row - 1],
                });
            }
        }
        Ok(())
    }

    fn check_rows(&self, mut columns: impl Iterator<Item = (&'static str, usize)>) -> Result<(), ArchiveError> {
        let expected = self.len();
        let ragged = columns.find(|(_, rows)| *rows != expected);
        ragged.map_or(Ok(()), |(column, rows)| Err(ArchiveError::Ragged { column, rows, expected }))
    }

    /// Writes the capture as an MCAP archive, with its description and attachments, where there is none yet.
    ///
    /// Columns that the capture does not have become NaN, which reads back as absent.
    ///
    /// # Errors
    /// What [`validate`](Self::validate) reports, [`ArchiveError::SharedTick`] when the rows are not
    /// evenly spaced, or what [`write_whole`](whole_file::write_whole) does.
    pub fn write_mcap(&self, path: &Path) -> Result<(), ArchiveError> {
        whole_file::write_whole(path, Replace::Nothing, |place| self.write_mcap_to(place))
    }

    /// [`write_mcap`](Self::write_mcap) without a file.
    ///
    /// # Errors
    /// As there.
    pub fn write_mcap_to<W: Write + Seek>(&self, output: W) -> Result<(), ArchiveError> {
        self.validate()?;
        let run = self.description_or_default();
        let mut writer = CaptureWriter::new(output, &run)?;
        for (name, content) in &self.attachments {
            if !is_described_by_run(name, &run) {
                writer.attach(name, media_type(name), content)?;
            }
        }
        for change in &self.models {
            writer.model(change)?;
        }
        let mut unmeasured = self.unmeasured.iter().peekable();
        for row in 0..self.len() {
            if row > 0 && self.tick[row] <= self.tick[row - 1] {
                return Err(ArchiveError::SharedTick { row: row + 1, rate_hz: self.rate_hz });
            }
            while let Some(sample) = unmeasured.next_if(|sample| sample.seq < self.seq[row]) {
                writer.sample(sample)?;
            }
            writer.sample(&self.sample(row, &run))?;
        }
        for sample in unmeasured {
            writer.sample(sample)?;
        }
        // No later sample shows those that are missing at the end.
        let next = writer.ledger().next();
        if let Some(gap) = self.gaps.last().filter(|gap| gap.first_missing_seq == next) {
            writer.published(gap.last_missing_seq.saturating_add(1));
        }
        writer.finish()?;
        Ok(())
    }

    /// Writes the capture as a CSV table, where there is none yet; every number reads back to the last bit.
    ///
    /// # Errors
    /// What [`validate`](Self::validate) reports, or what [`write_whole`](whole_file::write_whole) does.
    pub fn write_csv(&self, path: &Path) -> Result<(), ArchiveError> {
        self.validate()?;
        whole_file::write_whole(path, Replace::Nothing, |place| csv_file::write(self, place))
    }

    /// The run's description, or that of an unknown run on an unknown rig.
    #[must_use]
    pub fn description_or_default(&self) -> RunDescription {
        let unknown = || RunDescription {
            software_version: env!("CARGO_PKG_VERSION").to_owned(),
            apparatus: "unknown".to_owned(),
            knob: "unknown".to_owned(),
            planned_ticks: self.len() as u64,
            ..RunDescription::default()
        };
        RunDescription { rate_hz: self.rate_hz, axis: self.axis, ..self.description.clone().unwrap_or_else(unknown) }
    }

    /// A row as a sample of the run.
    pub(crate) fn sample(&self, row: usize, run: &RunDescription) -> Sample {
        let since_start_ns = (self.tick[row] as f64 * 1e9 / self.rate_hz).round() as u64;
        let monotonic_time_ns = run.clock.monotonic_time_ns.saturating_add(since_start_ns);
        let mut sample = Sample { monotonic_time_ns, ..Sample::default() };
        for fill in columns::of_samples().filter_map(|column| column.fill) {
            fill(&mut sample, self, row);
        }
        sample
    }
}

/// True for attachments that the writer makes from the run's description.
fn is_described_by_run(name: &str, run: &RunDescription) -> bool {
    match name {
        attachment::RUN | attachment::CHANNELS => true,
        attachment::EXCITATION => !run.excitation_toml.is_empty(),
        attachment::CALIBRATION => !run.calibration_toml.is_empty(),
        attachment::MODEL => run.rendered_model_toml.is_some() || run.simulated_knob_toml.is_some(),
        _ => false,
    }
}

fn media_type(name: &str) -> &'static str {
    match name.rsplit('.').next() {
        Some("toml") => "application/toml",
        Some("json") => "application/json",
        Some("csv") => "text/csv",
        _ => "application/octet-stream",
    }
}

/// Bytes at a table's beginning that show how long its rows are.
const ROWS_SHOWN: usize = 64 << 10;

/// Refuses a file for which the machine has not enough memory; each row of a table takes `of_row` bytes beside its length.
pub(crate) fn refuse_too_large(path: &Path, of_row: f64) -> Result<(), ArchiveError> {
    let length = std::fs::metadata(path).map_err(|error| ArchiveError::file(path, error))?.len() as f64;
    let head = first_bytes(path, ROWS_SHOWN)?;
    let needed = memory_for(length, &head, of_row);
    match memory::available() {
        Some(available) if needed > available => {
            Err(ArchiveError::TooLarge { path: path.to_owned(), length, needed, available })
        }
        _ => Ok(()),
    }
}

/// Bytes of memory for a file of that length that begins like this.
fn memory_for(length: f64, head: &[u8], of_row: f64) -> f64 {
    let lines = head.iter().filter(|byte| **byte == b'\n').count() as f64;
    let rows = length * lines / (head.len() as f64).max(1.0);
    length * memory::OF_FILE + rows * of_row
}

/// Whether a file is an MCAP archive, by its content; otherwise it is text.
///
/// # Errors
/// For a file that is neither.
pub(crate) fn is_mcap(path: &Path) -> Result<bool, ArchiveError> {
    let first_bytes = first_bytes(path, mcap::MAGIC.len())?;
    if first_bytes.is_empty() {
        return Err(ArchiveError::Empty { path: path.to_owned() });
    }
    if first_bytes == mcap::MAGIC {
        return Ok(true);
    }
    if mcap::MAGIC.starts_with(&first_bytes) {
        return Err(ArchiveError::Truncated { path: path.to_owned() });
    }
    let is_utf_16 = first_bytes.starts_with(&[0xff, 0xfe]) || first_bytes.starts_with(&[0xfe, 0xff]);
    if first_bytes.contains(&0) && !is_utf_16 || path.extension().is_some_and(|extension| extension == "mcap") {
        return Err(ArchiveError::NotACapture { path: path.to_owned() });
    }
    Ok(false)
}

/// So many bytes of a file's beginning, or all that it has.
pub(crate) fn first_bytes(path: &Path, count: usize) -> Result<Vec<u8>, ArchiveError> {
    use std::io::Read as _;
    let mut bytes = Vec::new();
    foreign_files::open(path)
        .and_then(|file| file.take(count as u64).read_to_end(&mut bytes))
        .map_err(|error| ArchiveError::file(path, error))?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::{ArchiveError, Capture, memory, memory_for};

    #[test]
    fn columns_that_only_archives_have_are_as_long_as_the_others() {
        let whole = Capture::from_columns(100.0, vec![0.0, 1.0, 2.0], vec![0.0; 3]);
        assert!(whole.validate().is_ok());
        let ragged = Capture { device_code: Some(vec![0; 2]), ..whole };
        assert!(matches!(ragged.validate(), Err(ArchiveError::Ragged { column: "device_code", rows: 2, expected: 3 })));
    }

    #[test]
    fn short_rows_need_more_memory_for_each_byte_than_long_ones() {
        let of = |row: &str| memory_for(1e9, row.repeat(100).as_bytes(), memory::OF_FOREIGN_ROW) / 1e9;
        assert!(of("1,2,3\n") > 50.0 && of("0.0012,0.234567,-12.3456\n") > 14.0);
        assert!(of(&format!("{}\n", "0.123456789,".repeat(50))) < 5.0);
        assert_eq!(memory_for(1e9, b"", memory::OF_ROW), 4e9);
    }
}
