//! The part of a rig's description that comes from its file, alike for all drivers of devices with channels.

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
        let mut calibration = self.needed(calibration.as_ref(), "[calibration] with motor_inertia")?.clone();
        // A file of its own is one that `calibrate` wrote: its delays are whole.
        if self.calibration_file.is_none() {
            calibration.torque_delay_s += wiring.torque_delay_s;
            calibration.acceleration_delay_s += wiring.acceleration_delay_s;
        }
        let fastest_hz = self.rates.map_or(limits.rate_hz, |rates| rates.fastest_hz.min(limits.rate_hz));
        let slowest_hz = self.rates.map_or(SLOWEST_HZ, |rates| rates.slowest_hz);
        let unseen_rad = limits.speed_rad_s * f64::from(watchdog.stale_ticks + 1) / slowest_hz;
        if let Some(count_rad) = wiring.angle_count_rad().filter(|count_rad| 0.5 * count_rad <= unseen_rad) {
            return Err(self.error(format!(
                "[channels.angle] wraps_at: within [watchdog] stale_ticks at [limits] speed_rad_s the encoder may turn by {unseen_rad:.3} rad, more \
                 than half of the {count_rad:.3} rad after which it begins anew, so that its way is not known; lower one of them, or \
                 raise [rates] slowest_hz"
            )));
        }
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
            slowest_rate_hz: slowest_hz,
            calibration,
            torque: wiring.torque_source,
            has_contact: wiring.has_contact(),
            torque_late_ticks: 1.0,
            angle_delay_s: wiring.angle_delay_s,
            stale_limit: watchdog.stale_ticks,
            watchdog_s: None,
            device: self.device.clone(),
            calls: self.declared_calls(),
            codes: Vec::new(),
            notes,
        })
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::plugin::TEMPLATE;

    fn described(text: &str, path: &Path) -> Result<RigDescription, RigFileError> {
        let file = RigFile::parse(text, path)?;
        let names = ["encoder", "torque"].map(str::to_owned);
        file.description(&file.needed_channels()?.wire(&names).unwrap().held_between_exchanges(1_000.0))
    }

    #[test]
    fn an_encoder_that_may_turn_unseen_by_half_of_its_count_is_refused() {
        let wraps_at = |count: &str| TEMPLATE.replace("# wraps_at = 4096 ", &format!("wraps_at = {count} "));
        let path = Path::new("rig.toml");
        assert!(described(&wraps_at("4096"), path).is_ok());
        let refused = described(&wraps_at("512"), path).unwrap_err().to_string();
        assert!(refused.contains("wraps_at") && refused.contains("2.520 rad"), "{refused}");
    }

    #[test]
    fn the_delay_of_the_angle_is_one_of_the_loop() {
        let of_delay = |delay_s: &str| {
            let text = TEMPLATE.replace("[channels.angle] ", &format!("[channels.angle]\ndelay_s = {delay_s} "));
            described(&text, Path::new("rig.toml")).unwrap()
        };
        let late = of_delay("5e-4");
        assert!((late.late_ticks(2_000.0) - late.torque_late_ticks - 1.0).abs() < 1e-12);
        assert_eq!(of_delay("-5e-4").late_ticks(2_000.0), late.torque_late_ticks);
    }

    #[test]
    fn delays_of_the_channels_are_added_to_those_of_the_table_but_not_to_a_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rig.toml");
        let text = TEMPLATE.replace("delay_s = 0.0 ", "delay_s = 2e-4 ");
        let mut known = described(&text, &path).unwrap().calibration;
        assert!((known.torque_delay_s - 7e-4).abs() < 1e-12, "{}", known.torque_delay_s);
        known.torque_delay_s = 6.9e-4;
        std::fs::write(folder.path().join("known.toml"), known.to_toml()).unwrap();
        let (before, _) = text.split_once("[calibration]").unwrap();
        let file = described(&format!("calibration_file = \"known.toml\"\n{before}"), &path).unwrap();
        assert!((file.calibration.torque_delay_s - 6.9e-4).abs() < 1e-12);
    }
}
