//! The part of a rig's description that comes from its file, alike for all drivers of devices with channels.

use dynamics::Calibration;

use crate::channels::Wiring;
use crate::{Channels, Limits, RigDescription, RigFile, RigFileError, TorqueSource, Watchdog};

/// Slowest sample rate of a rig that does not say, Hz.
const SLOWEST_HZ: f64 = 500.0;

impl RigFile {
    fn needed<'a, Part>(&self, part: Option<&'a Part>, what: &str) -> Result<&'a Part, RigFileError> {
        let driver = &self.driver;
        part.ok_or_else(|| {
            self.error(format!("a rig with the driver '{driver}' needs {what}; `haptic-camera rig new` writes one"))
        })
    }

    /// Its channels, which a device with channels must have.
    ///
    /// # Errors
    /// [`RigFileError`] where they are missing.
    pub fn needed_channels(&self) -> Result<&Channels, RigFileError> {
        self.needed(self.channels.as_ref(), "[channels]")
    }

    /// Its watchdog, which a device with channels must have.
    ///
    /// # Errors
    /// [`RigFileError`] where it is missing.
    pub fn needed_watchdog(&self) -> Result<Watchdog, RigFileError> {
        self.needed(self.watchdog.as_ref(), "[watchdog]").copied()
    }

    /// What it says of a rig with channels that are wired so; the driver adds what its device says.
    ///
    /// # Errors
    /// [`RigFileError`] for what is missing, or cannot be read.
    pub fn description(&self, wiring: &Wiring) -> Result<RigDescription, RigFileError> {
        let limits = *self.needed(self.limits.as_ref(), "[limits]")?;
        let watchdog = self.needed_watchdog()?;
        let calibration = self.calibration()?;
        let calibration = self.needed(calibration.as_ref(), "[calibration] with motor_inertia")?;
        let fastest_hz = self.rates.map_or(limits.rate_hz, |rates| rates.fastest_hz.min(limits.rate_hz));
        let mut notes = vec![
            ("driver".to_owned(), self.driver.clone()),
            ("watchdog asked for".to_owned(), format!("{} s", watchdog.timeout_s)),
        ];
        if wiring.torque_source == TorqueSource::Motor {
            let note = "the motor's: friction and cogging include the motor's own, and inertia what the calibration does not know \
                        of it";
            notes.push(("torque".to_owned(), note.to_owned()));
        }
        notes.extend(wiring.doubled_delay().map(|note| ("delay".to_owned(), note)));
        Ok(RigDescription {
            name: self.name.clone(),
            limits: Limits { rate_hz: fastest_hz, ..limits },
            slowest_rate_hz: self.rates.map_or(SLOWEST_HZ, |rates| rates.slowest_hz),
            calibration: Calibration {
                torque_delay_s: calibration.torque_delay_s + wiring.torque_delay_s,
                acceleration_delay_s: calibration.acceleration_delay_s + wiring.acceleration_delay_s,
                ..calibration.clone()
            },
            torque: wiring.torque_source,
            has_contact: wiring.has_contact(),
            torque_late_ticks: 1.0,
            stale_limit: watchdog.stale_ticks,
            watchdog_s: None,
            device: self.device.clone(),
            calls: self.declared_calls(),
            codes: Vec::new(),
            notes,
        })
    }
}
