//! A rig behind a shared library: NI, Quanser, Sensoray, MCC and Comedi cards, and every SDK that C can call.
//!
//! The library has the functions of `haptic_rig.h`, which lies beside this file. It reads channels in its device's own units; the
//! rig file says which of them are angle, torque and acceleration, and how they are scaled.

mod interface;

use std::ffi::CString;
use std::path::PathBuf;

pub use interface::{ABI, PluginError};
use interface::{OpenRig, Raw};
use serde::Deserialize;

use crate::channels::Wiring;
use crate::{Apparatus, ApparatusError, Measurement, RawMeasurement, RigDescription, RigFile, RigFileError};

/// The interface that a library implements.
pub const HEADER: &str = include_str!("haptic_rig.h");
/// A rig file to begin with.
pub const TEMPLATE: &str = include_str!("template.toml");

/// What the driver itself takes of the settings; the library gets all of them.
#[derive(Deserialize)]
struct Settings {
    library: PathBuf,
}

/// A rig that a shared library drives.
pub struct PluginRig {
    description: RigDescription,
    library: OpenRig,
    wiring: Wiring,
    /// The torque of the last exchange, mNm.
    torque_mnm: f64,
    shift_ns: i64,
    asked_watchdog_s: f64,
    is_on: bool,
}

/// Why a plug-in rig cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum PluginRigError {
    /// Its file.
    #[error(transparent)]
    File(#[from] RigFileError),
    /// Its library.
    #[error("the rig '{name}': {error}")]
    Library {
        /// The rig's name.
        name: String,
        /// What is wrong with it.
        error: PluginError,
    },
}

impl PluginRig {
    /// Loads the library that the file names and opens its rig, for a run at `rate_hz`.
    ///
    /// # Errors
    /// [`PluginRigError`], in a sentence that names the rig.
    pub fn open(file: &RigFile, rate_hz: f64) -> Result<Self, PluginRigError> {
        let Settings { library } = settings(file)?;
        // A name without a folder would be looked for where the system keeps its libraries.
        let beside = file.beside(&library);
        let path = std::path::absolute(&beside).unwrap_or(beside);
        let watchdog = file.needed_watchdog()?;
        let channels = file.needed_channels()?;
        let of_library = |error| PluginRigError::Library { name: file.name.clone(), error };
        let mut library = OpenRig::open(&path, &as_text(file, rate_hz, watchdog.timeout_s)?).map_err(of_library)?;
        let described = library.describe().map_err(of_library)?;
        let wiring = channels.wire(&described.channels).map_err(|error| file.error(error))?.at_rate(rate_hz);
        let description = file.description(&wiring)?;
        let device = file.device.clone().unwrap_or_else(|| path.to_string_lossy().into_owned());
        let mut notes = description.notes;
        notes.push(("library".to_owned(), path.display().to_string()));
        notes.extend(described.name.map(|name| ("device".to_owned(), name)));
        let codes = described.codes.into_iter().map(|(code, meaning)| (code, format!("code {code}: {meaning}")));
        let description = RigDescription {
            torque_late_ticks: if library.takes_torque_at_once() { 0.0 } else { 1.0 },
            watchdog_s: described.watchdog_s,
            device: Some(device),
            codes: codes.collect(),
            notes,
            ..description
        };
        let asked_watchdog_s = watchdog.timeout_s;
        Ok(Self { description, library, wiring, torque_mnm: 0.0, shift_ns: 0, asked_watchdog_s, is_on: false })
    }
}

/// What the driver takes of the settings.
fn settings(file: &RigFile) -> Result<Settings, RigFileError> {
    file.settings()
}

/// The settings as the library gets them, with the sample rate and the watchdog's time.
fn as_text(file: &RigFile, rate_hz: f64, watchdog_s: f64) -> Result<Vec<(CString, CString)>, RigFileError> {
    let own = file.settings.iter().map(|(key, value)| {
        let value = match value {
            toml::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        (key.clone(), value)
    });
    let added = [("rate_hz".to_owned(), rate_hz.to_string()), ("watchdog_s".to_owned(), watchdog_s.to_string())];
    let c_text = |text: String| {
        CString::new(text).map_err(|_| file.error("[settings] holds a zero byte, which no library can be given"))
    };
    own.chain(added).map(|(key, value)| Ok((c_text(key)?, c_text(value)?))).collect()
}

fn result(code: i32) -> Result<(), ApparatusError> {
    if code == 0 { Ok(()) } else { Err(ApparatusError::Device(code)) }
}

impl Apparatus for PluginRig {
    fn description(&self) -> &RigDescription {
        &self.description
    }

    fn prepare(&mut self, stop: &dyn Fn() -> bool) -> Result<(), ApparatusError> {
        let prepared = result(self.library.prepare(stop));
        if stop() {
            return Err(ApparatusError::Stopped);
        }
        prepared?;
        if let Ok(described) = self.library.describe() {
            self.description.watchdog_s = described.watchdog_s;
        }
        // A watchdog that is longer than the file asks for is none that it may rely on.
        match self.description.watchdog_s {
            Some(read_back_s) if read_back_s > self.asked_watchdog_s * 1.001 => Err(ApparatusError::SlowWatchdog),
            _ => Ok(()),
        }
    }

    fn enable(&mut self) -> Result<(), ApparatusError> {
        self.is_on = true;
        result(self.library.enable())
    }

    fn disable(&mut self) {
        if std::mem::take(&mut self.is_on) {
            self.library.disable();
        }
    }

    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError> {
        let mut raw = Raw::default();
        result(self.library.exchange(due_ns, self.wiring.of_motor(torque_mnm), &mut raw))?;
        self.shift_ns = raw.shift_ns;
        let after_ns = if raw.time_ns == 0 { 0 } else { raw.time_ns.wrapping_sub(due_ns).cast_signed() };
        let read = RawMeasurement { values: raw.value, valid: raw.valid, after_s: after_ns as f64 * 1e-9 };
        let before_mnm = std::mem::replace(&mut self.torque_mnm, torque_mnm);
        // A device that takes the torque with the exchange was measured while the torque before it still acted.
        let acting_mnm = if self.library.takes_torque_at_once() { torque_mnm } else { before_mnm };
        Ok(self.wiring.measurement(&read, acting_mnm))
    }

    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        result(self.library.write_torque(self.wiring.of_motor(torque_mnm)))
    }

    fn shift_ns(&self) -> i64 {
        self.shift_ns
    }
}

impl Drop for PluginRig {
    fn drop(&mut self) {
        self.disable();
    }
}
