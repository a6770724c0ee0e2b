//! The rig file: what a lab says of its rig.

use std::path::{Path, PathBuf};

use dynamics::{Axis, Calibration, CalibrationError};
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::{Channels, DeclaredCalls, Limits};

/// A rig as its file describes it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigFile {
    /// The rig's name.
    pub name: String,
    /// Whether it turns; the file of one that presses or slides has the names and units of that.
    #[serde(default)]
    pub axis: Axis,
    /// The driver that drives it.
    pub driver: String,
    /// What one run at a time may hold, whatever its runtime directory: a device node, an address.
    pub device: Option<String>,
    /// What the driver alone understands.
    #[serde(default)]
    pub settings: toml::Table,
    /// How the device's channels are turned into angle, torque and acceleration, and torque into the motor's.
    pub channels: Option<Channels>,
    /// What the rig must not exceed.
    pub limits: Option<Limits>,
    /// Sample rates that it holds.
    pub rates: Option<Rates>,
    /// When the rig goes torque-free by itself, and how long the loop waits for new values.
    pub watchdog: Option<Watchdog>,
    /// System calls that it makes in a tick.
    pub calls: Option<CallsTable>,
    /// The rig's calibration in a file of its own, beside this one.
    pub calibration_file: Option<PathBuf>,
    /// The rig's calibration; what it leaves out is zero, and the torque sensor rigid.
    pub calibration: Option<toml::Table>,
    /// Where it was read from; empty for one that ships.
    #[serde(skip)]
    path: PathBuf,
}

/// Sample rates that a rig holds.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rates {
    /// Slowest, Hz.
    pub slowest_hz: f64,
    /// Fastest, Hz; not faster than the limits say.
    pub fastest_hz: f64,
}

/// When a rig goes torque-free.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Watchdog {
    /// Longest time without a command after which the amplifier must have taken the torque away, s.
    pub timeout_s: f64,
    /// Most ticks in a row without new data from the sensors.
    #[serde(default)]
    pub stale_ticks: u32,
}

/// System calls of a rig, as a file has them.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CallsTable {
    names: Vec<String>,
    per_tick: u32,
}

/// Why a rig file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("the rig file {}: {reason}", path.display())]
pub struct RigFileError {
    path: PathBuf,
    reason: String,
}

impl RigFile {
    /// Reads a rig file.
    ///
    /// # Errors
    /// [`RigFileError`] with the path.
    pub fn load(path: &Path) -> Result<Self, RigFileError> {
        let text = foreign_files::read_text(path).map_err(|error| RigFileError {
            path: path.to_owned(),
            reason: format!("it cannot be read ({error}); check the path"),
        })?;
        Self::parse(&text, path)
    }

    /// Reads the text of a rig file that lies, or would lie, at `path`.
    ///
    /// # Errors
    /// [`RigFileError`] for a text that is none, and for a key that no rig file has.
    pub fn parse(text: &str, path: &Path) -> Result<Self, RigFileError> {
        let wrong = |reason: String| RigFileError { path: path.to_owned(), reason };
        let located = |error: toml::de::Error| wrong(in_one_line(&error, text));
        let table: toml::Table = text.parse().map_err(located)?;
        let read: Self = if table.get("axis").and_then(toml::Value::as_str) == Some("linear") {
            let axis = Axis::Linear;
            let other =
                |key: String| wrong(format!("'{key}' is no name on a linear axis; it would be '{}'", axis.words(&key)));
            let within = axis.table_within(table).map_err(other)?;
            within.try_into().map_err(|error: toml::de::Error| wrong(axis.words(error.message()).replace('\n', " ")))?
        } else {
            toml::from_str(text).map_err(located)?
        };
        let file = Self { path: path.to_owned(), ..read };
        file.check()?;
        Ok(file)
    }

    fn check(&self) -> Result<(), RigFileError> {
        let above_zero = |table: &str, key: &str, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(self.error(format!("[{table}] {key} is {value}, but it must be above zero, and finite"))),
        };
        if let Some(limits) = &self.limits {
            let Limits { motor_torque_mnm, sensor_torque_mnm, speed_rad_s, angle_rad, following_error_rad, rate_hz } =
                limits;
            above_zero("limits", "motor_torque_mnm", *motor_torque_mnm)?;
            above_zero("limits", "sensor_torque_mnm", *sensor_torque_mnm)?;
            above_zero("limits", "speed_rad_s", *speed_rad_s)?;
            above_zero("limits", "angle_rad", *angle_rad)?;
            above_zero("limits", "following_error_rad", *following_error_rad)?;
            above_zero("limits", "rate_hz", *rate_hz)?;
        }
        if let Some(Rates { slowest_hz, fastest_hz }) = self.rates {
            above_zero("rates", "slowest_hz", slowest_hz)?;
            above_zero("rates", "fastest_hz", fastest_hz)?;
            if slowest_hz > fastest_hz {
                return Err(self.error("[rates] slowest_hz is above fastest_hz; exchange them"));
            }
        }
        if let Some(watchdog) = self.watchdog {
            above_zero("watchdog", "timeout_s", watchdog.timeout_s)?;
        }
        if let Some(channels) = &self.channels {
            channels.check().map_err(|error| self.error(error))?;
        }
        Ok(())
    }

    /// An error of this file.
    pub fn error(&self, reason: impl std::fmt::Display) -> RigFileError {
        let path = if self.path.as_os_str().is_empty() { PathBuf::from(&self.name) } else { self.path.clone() };
        RigFileError { path, reason: reason.to_string() }
    }

    /// What its driver needs of it.
    ///
    /// # Errors
    /// [`RigFileError`] for a key that is missing or that the driver does not know.
    pub fn settings<Settings: DeserializeOwned>(&self) -> Result<Settings, RigFileError> {
        let read = Settings::deserialize(toml::Value::Table(self.settings.clone()));
        read.map_err(|error| self.error(format!("[settings]: {}", error.message())))
    }

    /// A path in the file: beside the file, unless it is absolute.
    #[must_use]
    pub fn beside(&self, path: &Path) -> PathBuf {
        self.path.parent().map_or_else(|| path.to_owned(), |folder| folder.join(path))
    }

    /// The system calls that it makes in a tick.
    #[must_use]
    pub fn declared_calls(&self) -> DeclaredCalls {
        self.calls.as_ref().map_or_else(DeclaredCalls::default, |calls| DeclaredCalls {
            names: calls.names.clone(),
            per_tick: calls.per_tick,
        })
    }

    /// The calibration that the file has or names; `None` where it has none.
    ///
    /// # Errors
    /// [`RigFileError`] for one that cannot be read, and for both at once.
    pub fn calibration(&self) -> Result<Option<Calibration>, RigFileError> {
        let located = |error: CalibrationError| self.error(error);
        match (&self.calibration_file, &self.calibration) {
            (Some(_), Some(_)) => {
                Err(self.error("it has both calibration_file and [calibration]; leave one of them out"))
            }
            (Some(path), None) => Calibration::load(&self.beside(path)).map(Some).map_err(located),
            (None, Some(given)) => {
                let motor_inertia = given.get("motor_inertia").and_then(as_number);
                if !motor_inertia.is_some_and(|inertia| inertia > 0.0) {
                    return Err(self.error(
                        "[calibration] motor_inertia must be above zero, since the servo's gains follow from it: write a guess in \
                         mNm·s²/rad (0.02 for a small motor), then run `haptic-camera rig commission`, which finds it",
                    ));
                }
                let mut table = neutral();
                table.extend(given.clone());
                // The table has the program's own names by now, so an error is put back into the axis's words. The merged table has no
                // places in the file: the parser's message is all that the error tells.
                if let Err(error) = Calibration::deserialize(toml::Value::Table(table.clone())) {
                    return Err(self.error(format!("[calibration]: {}", self.axis.words(error.message()))));
                }
                let read = Calibration::from_toml(&table.to_string());
                read.map(|calibration| Some(Calibration { axis: self.axis, ..calibration }))
                    .map_err(|error| self.error(format!("[calibration]: {error}")))
            }
            (None, None) => Ok(None),
        }
    }
}

/// Defaults of a calibration: zeros, and a rigid torque sensor. The motor's inertia has no default; the file must state it.
fn neutral() -> toml::Table {
    let zero = [
        "gripper_inertia",
        "torque_zero_mnm",
        "torque_delay_s",
        "acceleration_zero_rad_s2",
        "acceleration_delay_s",
        "gravity_amplitude_rad_s2",
        "gravity_phase_rad",
        "angle_step_rad",
        "torque_step_mnm",
        "acceleration_step_rad_s2",
    ];
    let zeros = zero.into_iter().map(|key| (key.to_owned(), toml::Value::Float(0.0)));
    zeros.chain([("torque_sensor_stiffness_mnm_rad".to_owned(), toml::Value::Float(RIGID_MNM_RAD))]).collect()
}

fn as_number(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64))
}

/// Stiffness of a torque sensor that does not yield, mNm/rad.
const RIGID_MNM_RAD: f64 = 1e9;

/// The parser's word with the line that it is about.
fn in_one_line(error: &toml::de::Error, text: &str) -> String {
    let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count() + 1);
    let message = error.message().replace('\n', " ");
    line.map_or_else(|| message.clone(), |line| format!("line {line}: {message}"))
}
