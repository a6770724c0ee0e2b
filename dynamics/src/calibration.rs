//! The calibration of a rig: its measured properties.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::Axis;

/// A rig's calibration: the corrections that a capture needs, and the step of each sensor.
///
/// Kept beside every capture as TOML.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// The axis of the rig. The file of a linear rig has the names and units of a linear axis.
    #[serde(default, skip_serializing_if = "Axis::is_rotary")]
    pub axis: Axis,
    /// Inertia that turns with the knob beyond the torque sensor (gripper, half the coupling), mNm·s²/rad.
    pub gripper_inertia: f64,
    /// Inertia on the motor's side of the torque sensor, mNm·s²/rad.
    pub motor_inertia: f64,
    /// Stiffness of the torque sensor, mNm/rad: the knob is behind the encoder by torque over stiffness.
    pub torque_sensor_stiffness_mnm_rad: f64,
    /// Torque sensor's reading with nothing attached, mNm.
    pub torque_zero_mnm: f64,
    /// Delay of the torque channel behind the encoder, s.
    pub torque_delay_s: f64,
    /// Accelerometer's reading at rest, gravity apart, rad/s².
    pub acceleration_zero_rad_s2: f64,
    /// Delay of the acceleration channel behind the encoder, s.
    pub acceleration_delay_s: f64,
    /// Amplitude of gravity in the acceleration signal, rad/s²: g over the sensor's radius.
    pub gravity_amplitude_rad_s2: f64,
    /// Phase of gravity: the signal is amplitude · sin(angle + phase), rad.
    pub gravity_phase_rad: f64,
    /// Step of the encoder, rad.
    pub angle_step_rad: f64,
    /// Step of the torque channel, mNm.
    pub torque_step_mnm: f64,
    /// Step of the acceleration channel, rad/s².
    pub acceleration_step_rad_s2: f64,
    /// Coulomb friction of the motor, its brushes and bearings, mNm; `None` where it was never measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_coulomb_mnm: Option<f64>,
    /// Viscous friction of the motor, mNm·s/rad; `None` where it was never measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_viscous: Option<f64>,
    /// Delay of the motor's torque behind its command, s: 1/(2π·bandwidth) of the amplifier's current loop. The holding of a command
    /// over a tick does not count. `None` where the delay is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command_delay_s: Option<f64>,
    /// Cogging of the motor, strongest harmonic first, none where it has none; `None` where it was never measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_cogging: Option<Vec<CoggingHarmonic>>,
}

/// One harmonic of a motor's cogging: at an encoder angle the rotor is held back by torque · sin(per_turn · angle + phase).
///
/// The angle is the encoder's: an encoder without an index loses its zero when it is switched off, and with it the cogging map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoggingHarmonic {
    /// Periods in a turn.
    pub per_turn: u32,
    /// Largest torque, mNm.
    pub torque_mnm: f64,
    /// Phase at angle zero, rad.
    pub phase_rad: f64,
}

impl CoggingHarmonic {
    /// The torque that holds the rotor back at an encoder angle, mNm.
    #[must_use]
    pub fn at_mnm(&self, angle_rad: f64) -> f64 {
        self.torque_mnm * (f64::from(self.per_turn) * angle_rad + self.phase_rad).sin()
    }
}

/// Why a calibration cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The file cannot be read.
    #[error("the calibration {} cannot be read ({reason}); check the path", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The system's word for it.
        reason: std::io::Error,
    },
    /// The text is not TOML, or not of a calibration's form.
    #[error("the calibration cannot be read: {0}")]
    Malformed(String),
    /// A value that no rig can have.
    #[error("the calibration has a {quantity} of {value}, but it must be {requirement}")]
    OutOfRange {
        /// The quantity's key.
        quantity: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// What is wrong with the text of a file.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: Box<CalibrationError>,
    },
}

/// Most harmonics of a motor's cogging, so that a tick of the control loop has time for them.
const MOST_COGGING: usize = 64;
/// Largest magnitude of any value but a stiffness, which may stand for a rigid sensor: far beyond every rig, and far from
/// where sums and squares are no longer finite.
const LARGEST: f64 = 1e9;

impl Calibration {
    /// The torque of the motor's cogging, as far as it is known, that holds the rotor back at an encoder angle, mNm.
    #[must_use]
    pub fn motor_cogging_mnm(&self, angle_rad: f64) -> f64 {
        self.motor_cogging.iter().flatten().map(|harmonic| harmonic.at_mnm(angle_rad)).sum()
    }

    /// Reads a calibration file.
    ///
    /// # Errors
    /// [`CalibrationError`] with the path.
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        let text = foreign_files::read_text(path)
            .map_err(|reason| CalibrationError::Unreadable { path: path.to_owned(), reason })?;
        Self::from_toml(&text).map_err(|error| CalibrationError::File { path: path.to_owned(), error: Box::new(error) })
    }

    /// Reads a calibration from TOML, and makes sure that servo, fit and simulation can work with it.
    ///
    /// # Errors
    /// [`CalibrationError`] with the parser's word for it, or the first value out of its range.
    pub fn from_toml(text: &str) -> Result<Self, CalibrationError> {
        let malformed =
            |error: toml::de::Error| CalibrationError::Malformed(error.to_string().trim().replace('\n', " "));
        let table: toml::Table = text.parse().map_err(malformed)?;
        let linear = table.get("axis").and_then(toml::Value::as_str) == Some("linear");
        let read: Self = if linear {
            let other = |key| CalibrationError::Malformed(format!("'{key}' is no name on a linear axis"));
            Axis::Linear.table_within(table).map_err(other)?.try_into().map_err(malformed)?
        } else {
            toml::from_str(text).map_err(malformed)?
        };
        read.check()?;
        Ok(read)
    }

    /// Checks that every value lies where that of a rig can.
    ///
    /// # Errors
    /// [`CalibrationError::OutOfRange`] for the first that does not.
    pub fn check(&self) -> Result<(), CalibrationError> {
        const STIFF: &str = "at least 1e-3, and finite";
        const NOT_NEGATIVE: &str = "at least zero, and at most 1e9";
        const ANY: &str = "between -1e9 and 1e9";
        const DELAY: &str = "less than 0.1 s either way";
        let any = |value: f64| value.abs() <= LARGEST;
        let not_negative = |value: f64| (0.0..=LARGEST).contains(&value);
        let delay = |value: f64| value.abs() < 0.1;
        let [coulomb_mnm, viscous, command_delay_s] =
            [self.motor_coulomb_mnm, self.motor_viscous, self.command_delay_s].map(Option::unwrap_or_default);
        let stiffness = self.torque_sensor_stiffness_mnm_rad;
        let inertia = self.motor_inertia;
        let cogging = self.motor_cogging.as_deref().unwrap_or_default();
        let harmonics = cogging.len() as f64;
        let checks = [
            ("motor_inertia", inertia, (1e-9..=LARGEST).contains(&inertia), "at least 1e-9, and at most 1e9"),
            ("gripper_inertia", self.gripper_inertia, not_negative(self.gripper_inertia), NOT_NEGATIVE),
            ("torque_sensor_stiffness_mnm_rad", stiffness, stiffness >= 1e-3 && stiffness.is_finite(), STIFF),
            ("torque_zero_mnm", self.torque_zero_mnm, any(self.torque_zero_mnm), ANY),
            ("torque_delay_s", self.torque_delay_s, delay(self.torque_delay_s), DELAY),
            ("acceleration_zero_rad_s2", self.acceleration_zero_rad_s2, any(self.acceleration_zero_rad_s2), ANY),
            ("acceleration_delay_s", self.acceleration_delay_s, delay(self.acceleration_delay_s), DELAY),
            ("gravity_amplitude_rad_s2", self.gravity_amplitude_rad_s2, any(self.gravity_amplitude_rad_s2), ANY),
            ("gravity_phase_rad", self.gravity_phase_rad, any(self.gravity_phase_rad), ANY),
            ("angle_step_rad", self.angle_step_rad, not_negative(self.angle_step_rad), NOT_NEGATIVE),
            ("torque_step_mnm", self.torque_step_mnm, not_negative(self.torque_step_mnm), NOT_NEGATIVE),
            (
                "acceleration_step_rad_s2",
                self.acceleration_step_rad_s2,
                not_negative(self.acceleration_step_rad_s2),
                NOT_NEGATIVE,
            ),
            ("motor_coulomb_mnm", coulomb_mnm, not_negative(coulomb_mnm), NOT_NEGATIVE),
            ("motor_viscous", viscous, not_negative(viscous), NOT_NEGATIVE),
            ("command_delay_s", command_delay_s, command_delay_s.abs() < 0.01, "less than 0.01 s either way"),
            ("number of harmonics of motor_cogging", harmonics, cogging.len() <= MOST_COGGING, "at most 64"),
        ];
        let in_cogging = cogging.iter().flat_map(|harmonic| [harmonic.torque_mnm, harmonic.phase_rad]);
        let in_cogging = in_cogging.map(|value| ("number in motor_cogging", value, any(value), ANY));
        match checks.into_iter().chain(in_cogging).find(|(_, _, permitted, _)| !permitted) {
            Some((quantity, value, _, requirement)) => {
                Err(CalibrationError::OutOfRange { quantity, value, requirement })
            }
            None => Ok(()),
        }
    }

    /// The calibration as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // A struct of numbers always has a TOML form.
        self.axis.words(&toml::to_string(self).unwrap_or_default()).into_owned()
    }

    /// The same rig as seen from the hand on its gripper, where the torque sensor reads minus the torque that the rendered knob takes.
    ///
    /// With this calibration and the sign of the torque reversed, a capture of a rendering is analysed as a capture of a knob: the gripper
    /// turns with the rendered knob and not beside it, and the gripper is ahead of the encoder by torque over stiffness.
    #[must_use]
    pub fn seen_from_the_hand(&self) -> Self {
        Self {
            gripper_inertia: -self.gripper_inertia,
            torque_zero_mnm: -self.torque_zero_mnm,
            torque_sensor_stiffness_mnm_rad: -self.torque_sensor_stiffness_mnm_rad,
            ..self.clone()
        }
    }

    /// The calibration for a torque that is the motor's: it also accelerates the rotor, whose inertia then counts with the gripper's.
    #[must_use]
    pub fn with_rotor(&self) -> Self {
        Self { gripper_inertia: self.gripper_inertia + self.motor_inertia, ..self.clone() }
    }

    /// The rig's own calibration, of one [with the rotor](Self::with_rotor).
    #[must_use]
    pub fn without_rotor(&self) -> Self {
        Self { gripper_inertia: (self.gripper_inertia - self.motor_inertia).max(0.0), ..self.clone() }
    }

    /// Whether this is a rig [seen from the hand](Self::seen_from_the_hand).
    #[must_use]
    pub fn is_seen_from_the_hand(&self) -> bool {
        self.torque_sensor_stiffness_mnm_rad < 0.0
    }

    /// Gravity in the acceleration signal at an angle, rad/s².
    #[must_use]
    pub fn gravity_rad_s2(&self, angle_rad: f64) -> f64 {
        self.gravity_amplitude_rad_s2 * (angle_rad + self.gravity_phase_rad).sin()
    }
}
