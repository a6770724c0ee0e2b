//! What is known of a rig from measurement.

use serde::{Deserialize, Serialize};

/// A rig's calibration: what a capture must be corrected by, and how well each sensor sees.
///
/// Kept beside every capture as TOML.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
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
    /// Delay of the motor's torque behind its command, the holding of a command over a tick apart, s: 1/(2π·bandwidth) of the
    /// amplifier's current loop; `None` where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub command_delay_s: Option<f64>,
    /// Cogging of the motor, strongest harmonic first, none where it has none; `None` where it was never measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor_cogging: Option<Vec<CoggingHarmonic>>,
}

/// One harmonic of a motor's cogging: at an encoder angle the rotor is held back by torque · sin(per_turn · angle + phase).
///
/// The angle is the encoder's: without an index that it finds again after it was switched off, a cogging map is lost.
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

/// A calibration that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("the calibration cannot be read: {0}")]
pub struct CalibrationError(String);

impl Calibration {
    /// Reads a calibration from TOML.
    ///
    /// # Errors
    /// [`CalibrationError`] with the parser's word for it.
    pub fn from_toml(text: &str) -> Result<Self, CalibrationError> {
        toml::from_str(text).map_err(|error| CalibrationError(error.to_string().trim().replace('\n', " ")))
    }

    /// The calibration as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        // A struct of numbers always has a TOML form.
        toml::to_string(self).unwrap_or_default()
    }

    /// The same rig as the hand on its gripper sees it, for whom the torque sensor reads minus what the rendered knob takes.
    ///
    /// With this and the torque's sign turned, a capture of a rendering is analysed as one of a knob: the gripper turns with the
    /// rendered knob and not beside it, and the gripper is ahead of the encoder by torque over stiffness.
    #[must_use]
    pub fn seen_from_the_hand(&self) -> Self {
        Self {
            gripper_inertia: -self.gripper_inertia,
            torque_zero_mnm: -self.torque_zero_mnm,
            torque_sensor_stiffness_mnm_rad: -self.torque_sensor_stiffness_mnm_rad,
            ..self.clone()
        }
    }

    /// Gravity in the acceleration signal at an angle, rad/s².
    #[must_use]
    pub fn gravity_rad_s2(&self, angle_rad: f64) -> f64 {
        self.gravity_amplitude_rad_s2 * (angle_rad + self.gravity_phase_rad).sin()
    }
}
