//! What the control loop needs of a rig.

use dynamics::Calibration;
use serde::{Deserialize, Serialize};

/// One reading of the sensors, in physical units, not yet corrected by calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Encoder angle, rad.
    pub angle_rad: f64,
    /// Accelerometer, gravity included, rad/s².
    pub acceleration_rad_s2: f64,
    /// Torque sensor: what knob and gripper take from the rig, mNm.
    pub torque_mnm: f64,
}

/// What the rig must not exceed; beyond it the loop goes torque-free.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Limits {
    /// Largest torque that may be commanded from the motor, mNm; commands are clipped to it.
    pub motor_torque_mnm: f64,
    /// Largest torque that the sensor may carry, mNm.
    pub sensor_torque_mnm: f64,
    /// Largest speed, rad/s.
    pub speed_rad_s: f64,
    /// Largest angle away from the start, rad.
    pub angle_rad: f64,
    /// Largest distance from the commanded angle, rad.
    pub following_error_rad: f64,
    /// Fastest sample rate that the rig holds, Hz.
    pub rate_hz: f64,
}

/// What a rig says of itself before a run.
#[derive(Clone, Debug, PartialEq)]
pub struct RigDescription {
    /// The rig's name.
    pub name: String,
    /// What it must not exceed.
    pub limits: Limits,
    /// What is known of it from measurement.
    pub calibration: Calibration,
    /// Further facts worth keeping with a capture, as name and value.
    pub notes: Vec<(String, String)>,
}

/// Why the apparatus could not do what was asked.
///
/// Plain data without heap, so that it can cross the real-time path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ApparatusError {
    /// A sensor did not answer or its value is unusable.
    #[error("a sensor of the rig did not answer; check its cable and supply")]
    Sensor,
    /// The amplifier refused or reported a fault of its own.
    #[error("the rig's amplifier reported a fault; switch it off and on and check its supply")]
    Amplifier,
    /// The amplifier's watchdog ran out because no torque was written in time.
    #[error("the amplifier's watchdog ran out and took the torque away; start the run again")]
    Watchdog,
}

/// A rig that turns a knob through a torque sensor.
///
/// The control loop owns it and calls, once per tick, [`read`](Self::read) and then
/// [`write_torque`](Self::write_torque), from a real-time thread: neither may allocate, lock, log or
/// block. Construction, [`enable`](Self::enable) and [`disable`](Self::disable) may take their time.
/// A rig whose process dies must go torque-free by itself (a watchdog in its amplifier).
pub trait Apparatus: Send {
    /// Name, limits and calibration.
    fn description(&self) -> &RigDescription;

    /// Switches the amplifier on, at zero torque.
    ///
    /// # Errors
    /// [`ApparatusError::Amplifier`] when it does not come on.
    fn enable(&mut self) -> Result<(), ApparatusError>;

    /// Switches the amplifier off: torque-free from here on, whatever is written.
    fn disable(&mut self);

    /// Reads all sensors at the tick that is due at `monotonic_time_ns` (CLOCK_MONOTONIC, never falling).
    ///
    /// # Errors
    /// [`ApparatusError`] when a sensor or the amplifier has failed since the last call.
    fn read(&mut self, monotonic_time_ns: u64) -> Result<Measurement, ApparatusError>;

    /// Sets the motor's torque until the next call, mNm.
    ///
    /// # Errors
    /// [`ApparatusError`] when the amplifier does not take it.
    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError>;
}
