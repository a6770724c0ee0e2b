//! What the file of a rig that is no simulation must say, and what follows from it whatever the driver.

use dynamics::Calibration;

use crate::channels::Wiring;
use crate::{Channels, DeclaredCalls, Limits, RigDescription, RigFile, RigFileError, TorqueSource, Watchdog};

/// Slowest sample rate of a rig that does not say, Hz.
const SLOWEST_HZ: f64 = 500.0;

/// The parts of a rig file that hardware needs.
pub(crate) struct Hardware<'a> {
    file: &'a RigFile,
    driver: &'static str,
    pub(crate) channels: &'a Channels,
    pub(crate) limits: Limits,
    pub(crate) watchdog: Watchdog,
    calibration: Calibration,
}

impl RigFile {
    /// What this file says of the hardware that `driver` drives.
    ///
    /// # Errors
    /// [`RigFileError`] for a table that is missing.
    pub(crate) fn of_hardware(&self, driver: &'static str) -> Result<Hardware<'_>, RigFileError> {
        let missing = |what: &str| {
            self.error(format!(
                "the driver '{driver}' needs {what}; `haptic-camera rig new --driver {driver}` writes one"
            ))
        };
        Ok(Hardware {
            file: self,
            driver,
            channels: self.channels.as_ref().ok_or_else(|| missing("[channels]"))?,
            limits: self.limits.ok_or_else(|| missing("[limits]"))?,
            watchdog: self.watchdog.ok_or_else(|| missing("[watchdog]"))?,
            calibration: self.calibration()?.ok_or_else(|| missing("[calibration] with motor_inertia"))?,
        })
    }
}

impl Hardware<'_> {
    /// What the rig is before it is prepared, but for what its driver alone knows.
    pub(crate) fn description(&self, wiring: &Wiring) -> RigDescription {
        let Self { file, channels: _, limits, watchdog, calibration, driver: _ } = self;
        let fastest_hz = file.rates.map_or(limits.rate_hz, |rates| rates.fastest_hz.min(limits.rate_hz));
        RigDescription {
            name: file.name.clone(),
            limits: Limits { rate_hz: fastest_hz, ..*limits },
            slowest_rate_hz: file.rates.map_or(SLOWEST_HZ, |rates| rates.slowest_hz),
            calibration: Calibration {
                torque_delay_s: calibration.torque_delay_s + wiring.torque_delay_s,
                acceleration_delay_s: calibration.acceleration_delay_s + wiring.acceleration_delay_s,
                ..calibration.clone()
            },
            torque: wiring.torque_source,
            takes_torque_at_exchange: true,
            stale_limit: watchdog.stale_ticks,
            watchdog_s: None,
            device: file.device.clone(),
            calls: DeclaredCalls::default(),
            codes: Vec::new(),
            notes: Vec::new(),
        }
    }

    /// What is worth keeping with a capture: the driver, what it knows itself, and where the torque comes from.
    pub(crate) fn notes(
        &self,
        wiring: &Wiring,
        own: impl IntoIterator<Item = (String, String)>,
    ) -> Vec<(String, String)> {
        let watchdog = ("watchdog asked for".to_owned(), format!("{} s", self.watchdog.timeout_s));
        let of_motor = (wiring.torque_source == TorqueSource::Motor).then(|| {
            let note = "the motor's: friction and cogging include the motor's own, and inertia what the calibration does not know \
                        of it";
            ("torque".to_owned(), note.to_owned())
        });
        [("driver".to_owned(), self.driver.to_owned())]
            .into_iter()
            .chain(own)
            .chain([watchdog])
            .chain(of_motor)
            .collect()
    }
}
