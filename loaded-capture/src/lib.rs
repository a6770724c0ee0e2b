//! A capture as every program loads it: the file, what is known of the rig that made it, and the columns that a fit takes.

mod joined;

use std::io::{Seek, Write};
use std::path::{Path, PathBuf};

use archive::testers::{ColumnChoice, Curve};
use archive::whole_file::{self, Replace, write_bytes};
use archive::{ArchiveError, Capture, attachment};
use dynamics::{Calibration, CalibrationError, Model, ModelError};
use identification::Samples;
use shared_types::RunDescription;

/// The first line of a calibration's file that was written here.
pub const CALIBRATION_MARK: &str = "## made by haptic-camera\n";
/// The second line of such a file beside the table of a replay, whose torque is that of the rendered knob.
const OF_REPLAY_MARK: &str = "## of a replay\n";

/// A capture with what is known of the rig that made it.
#[derive(Clone, Debug, Default)]
pub struct LoadedCapture {
    /// The capture.
    pub capture: Capture,
    /// The rig's calibration; `None` for a table without one.
    pub calibration: Option<Calibration>,
    /// The file beside a table from which the calibration was read.
    pub calibration_file: Option<PathBuf>,
    /// The knob that the simulated rig turned; `None` for a real one or a table.
    pub truth: Option<Model>,
    /// Whether it is a curve of load over position, in which time has no part.
    pub is_quasi_static: bool,
}

/// A capture that cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// The file itself.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The calibration in an archive.
    #[error("{}: {error}", path.display())]
    Calibration {
        /// The archive.
        path: PathBuf,
        /// What is wrong with it.
        error: CalibrationError,
    },
    /// The calibration beside a table.
    #[error(transparent)]
    CalibrationFile(#[from] CalibrationError),
    /// A folder that does not say whether a calibration lies beside a table.
    #[error("{} cannot be read ({error}); check the folder's permissions", path.display())]
    Beside {
        /// The calibration's place.
        path: PathBuf,
        /// The system's word for it.
        error: std::io::Error,
    },
    /// The model of the simulated knob.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl LoadedCapture {
    /// Reads a capture and its attachments; of a table, the calibration that an export put beside it.
    ///
    /// # Errors
    /// [`LoadError`], one sentence on what is wrong with a file.
    pub fn load(path: &Path) -> Result<Self, LoadError> {
        Self::load_chosen(path, None)
    }

    /// The capture's title in tables and on pages: its knob, where that is known, and its file.
    #[must_use]
    pub fn title(&self) -> String {
        let file = self.capture.file_name();
        let title = match &self.capture.description {
            Some(description) => format!("Knob {} ({file})", description.knob),
            None => file,
        };
        // Names of knobs and files are of any length.
        foreign_files::one_line(&title)
    }

    /// [`load`](Self::load) for a table or a measurement whose columns were chosen.
    ///
    /// # Errors
    /// [`LoadError`], one sentence on what is wrong with a file.
    pub fn load_chosen(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Self, LoadError> {
        Self::of(path, Capture::load_chosen(path, chosen)?)
    }

    /// The loaded form of a capture that was read from `path`, with its attachments or the files beside it.
    fn of(path: &Path, capture: Capture) -> Result<Self, LoadError> {
        let capture = capture.of_knob();
        let attached = capture.attached_text(attachment::CALIBRATION).filter(|text| !text.is_empty());
        let calibration_file =
            if attached.is_none() && capture.description.is_none() { existing_calibration_beside(path)? } else { None };
        let calibration = match (attached, &calibration_file) {
            (Some(text), _) => Some(
                Calibration::from_toml(text)
                    .map_err(|error| LoadError::Calibration { path: path.to_owned(), error })?,
            ),
            (None, Some(file)) => Some(Calibration::load(file)?),
            (None, None) => None,
        };
        let truth = capture
            .attached_text(attachment::MODEL)
            .map(|text| Model::from_toml(text, &format!("the model in {}", path.display())))
            .transpose()?;
        let of_replay = capture.is_rendered() || calibration_file.as_deref().is_some_and(is_of_replay);
        let seen = |known: Calibration| if of_replay { known.seen_from_the_hand() } else { known };
        let calibration = calibration.map(seen);
        Ok(Self { capture, calibration, calibration_file, truth, is_quasi_static: false })
    }

    /// The columns that a fit takes.
    #[must_use]
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.capture.t_s,
            angle_rad: &self.capture.angle_rad,
            velocity_rad_s: self.capture.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.capture.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.capture.torque_mnm,
        }
    }

    /// Reads a capture, or a tester's file as a capture. A tester's curve counts as quasi-static unless its time column was chosen or is ours.
    ///
    /// # Errors
    /// [`LoadError`], one sentence on what is wrong with a file.
    pub fn load_measured(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Self, LoadError> {
        if let Some(loaded) = capture_at(path, chosen)? {
            return Ok(loaded);
        }
        let mut curve = match Curve::load(path, chosen) {
            // The error that names the columns of a capture is more helpful than the one about formats of testers.
            Err(ArchiveError::UnknownTable { .. }) => return Self::load(path),
            read => read?,
        };
        if curve.is_of_motion {
            return Self::of(path, curve.into_capture()?);
        }
        let rises = |t_s: &Vec<f64>| t_s.windows(2).all(|pair| pair[1] > pair[0]);
        curve.t_s = curve.t_s.filter(rises);
        Ok(Self { capture: curve.into_capture()?, is_quasi_static: true, ..Self::default() })
    }

    /// Torque over angle, without the torque sensor's zero and delay.
    #[must_use]
    pub fn curve(&self) -> Curve {
        let Capture { t_s, angle_rad, torque_mnm, contact, source, .. } = &self.capture;
        let zero_mnm = self.calibration.as_ref().map_or(0.0, |known| known.torque_zero_mnm);
        let delay_s = self.calibration.as_ref().map_or(0.0, |known| known.torque_delay_s);
        Curve {
            source: source.clone(),
            axis: self.capture.axis,
            t_s: Some(t_s.clone()),
            is_of_motion: !self.is_quasi_static,
            position: earlier(t_s, angle_rad, delay_s),
            load: torque_mnm.iter().map(|torque_mnm| torque_mnm - zero_mnm).collect(),
            closed: contact
                .as_ref()
                .map(|contact| earlier(t_s, contact, delay_s).into_iter().map(|closed| closed > 0.5).collect()),
        }
    }

    /// Writes the columns that a fit takes as a table where there is no file yet, and the calibration, if known, into a file beside the
    /// table, from which [`load`](Self::load) reads it again. Returns the path of the calibration.
    ///
    /// # Errors
    /// [`ArchiveError`] where a file is in the way or cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<Option<PathBuf>, ArchiveError> {
        let Some(calibration) = &self.calibration else {
            self.capture.write_csv(path)?;
            return Ok(None);
        };
        let beside = calibration_beside(path);
        // A file holds a calibration as the rig has it.
        let text = if calibration.is_seen_from_the_hand() {
            format!("{CALIBRATION_MARK}{OF_REPLAY_MARK}{}", calibration.seen_from_the_hand().to_toml())
        } else {
            format!("{CALIBRATION_MARK}{}", calibration.to_toml())
        };
        // A calibration that differs may be the only copy of a rig's: it is not replaced.
        let is_the_same = std::fs::read(&beside).is_ok_and(|found| found == text.as_bytes());
        let replace = if is_the_same { Replace::Anything } else { Replace::Nothing };
        whole_file::check(&beside, replace)?;
        self.capture.write_csv(path)?;
        write_bytes(&beside, replace, text.as_bytes())?;
        Ok(Some(beside))
    }

    /// Writes the capture as an archive, with the torque as the rig's sensor reads it and the calibration.
    ///
    /// # Errors
    /// As [`Capture::write_mcap_to`].
    pub fn write_mcap_to<W: Write + Seek>(&self, output: W) -> Result<(), ArchiveError> {
        let mut capture = self.capture.clone().of_knob();
        // A table's calibration is in a file of its own. An archive cannot say that the rig rendered an unknown model.
        let of_table =
            self.calibration.as_ref().filter(|known| capture.description.is_none() && !known.is_seen_from_the_hand());
        if let Some(known) = of_table {
            let calibration_toml = known.to_toml();
            capture.description = Some(RunDescription { calibration_toml, ..capture.description_or_default() });
        }
        capture.write_mcap_to(output)
    }

    /// Torque commanded from the motor, mNm; `None` for a table or a simulation without it, and for a rendering, in which it does not
    /// drive the knob.
    #[must_use]
    pub fn commanded_torque_mnm(&self) -> Option<&[f64]> {
        self.capture.commanded_torque_mnm.as_deref().filter(|_| !self.capture.is_rendered())
    }
}

/// Load over position: of a capture of ours, or of a file of a tester with its columns as chosen or as its format has
/// them.
///
/// # Errors
/// [`LoadError`], one sentence on what is wrong with a file.
pub fn load_curve(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Curve, LoadError> {
    match capture_at(path, chosen)? {
        Some(loaded) => Ok(loaded.curve()),
        None => Ok(Curve::load(path, chosen)?),
    }
}

/// What is a capture as it stands: an archive, or a file with a time whose columns were not chosen; `None` for others.
fn capture_at(path: &Path, chosen: Option<&ColumnChoice>) -> Result<Option<LoadedCapture>, LoadError> {
    let is_one = if chosen.is_some() { Capture::is_archive(path)? } else { Capture::is_one(path)? };
    match is_one.then(|| LoadedCapture::load(path)).transpose() {
        Err(LoadError::Archive(ArchiveError::NoTime { .. })) => Ok(None),
        loaded => loaded,
    }
}

/// The place of an exported table's calibration.
#[must_use]
pub fn calibration_beside(table: &Path) -> PathBuf {
    table.with_extension("calibration.toml")
}

/// The calibration of an exported table; `None` for a table without one.
fn existing_calibration_beside(table: &Path) -> Result<Option<PathBuf>, LoadError> {
    let path = calibration_beside(table);
    match path.try_exists() {
        Ok(exists) => Ok(exists.then_some(path)),
        Err(error) => Err(LoadError::Beside { path, error }),
    }
}

/// Whether the table beside a calibration is one of a replay.
fn is_of_replay(calibration: &Path) -> bool {
    foreign_files::read_text(calibration).is_ok_and(|text| text.contains(OF_REPLAY_MARK))
}

/// The values as they were `delay_s` before each time, along straight lines.
fn earlier(t_s: &[f64], values: &[f64], delay_s: f64) -> Vec<f64> {
    let mut below = 0;
    let at = |time_s: &f64| {
        let wanted_s = time_s - delay_s;
        while below + 2 < t_s.len() && t_s[below + 1] <= wanted_s {
            below += 1;
        }
        let (from, to) = (below, (below + 1).min(t_s.len() - 1));
        let step_s = t_s[to] - t_s[from];
        let share = if step_s > 0.0 { ((wanted_s - t_s[from]) / step_s).clamp(0.0, 1.0) } else { 0.0 };
        values[from] + share * (values[to] - values[from])
    };
    t_s.iter().map(at).collect()
}
