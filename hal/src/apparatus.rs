//! What the control loop needs of a rig.

use dynamics::Calibration;
use serde::{Deserialize, Serialize};

/// One reading of the sensors, in physical units, not yet corrected by calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measurement {
    /// Encoder angle, rad.
    pub angle_rad: f64,
    /// Accelerometer, gravity included, rad/s²; `None` on a rig without one.
    pub acceleration_rad_s2: Option<f64>,
    /// Torque that knob and gripper take from the rig, mNm; see [`TorqueSource`] for rigs without a torque sensor.
    pub torque_mnm: f64,
    /// Whether the contact in what is turned or pressed is closed; `None` on a rig that watches none.
    pub contact: Option<bool>,
    /// How long after the tick was due the encoder was read, s; negative for before. A rig with a clock of its own dates readings
    /// by that clock: then the value grows as the two clocks drift apart.
    pub after_s: f64,
    /// Nothing new came for this tick: the values are those of an earlier one, or none.
    pub is_stale: bool,
    /// Why nothing new came, by the rig's own code; 0 where it does not say.
    pub stale_code: i32,
}

impl Measurement {
    /// Nothing new, for the reason that the rig's own code tells.
    #[must_use]
    pub fn stale(code: i32) -> Self {
        Self { is_stale: true, stale_code: code, ..Self::default() }
    }
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

/// Where the torque of a [`Measurement`] comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TorqueSource {
    /// A sensor between motor and gripper: the torque that gripper and knob take.
    #[default]
    Sensor,
    /// The motor's current, or its command: the torque that its rotor takes too.
    Motor,
}

/// System calls that a rig makes within a tick. None of them may block, but for a wait that ends within a share of the period.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DeclaredCalls {
    /// Their names, as the kernel has them: `ioctl`, `sendto`.
    pub names: Vec<String>,
    /// Most of them in one tick, all names together.
    pub per_tick: u32,
}

/// What a rig says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct RigDescription {
    /// The rig's name.
    pub name: String,
    /// What it must not exceed.
    pub limits: Limits,
    /// Slowest sample rate that the rig holds, Hz.
    pub slowest_rate_hz: f64,
    /// What is known of it from measurement.
    pub calibration: Calibration,
    /// Where its torque comes from.
    pub torque: TorqueSource,
    /// Whether it watches a contact in what is turned or pressed.
    pub has_contact: bool,
    /// Delay of a torque's effect beyond that of a rig that reads and drives at the tick, in ticks: 1 where the torque acts only
    /// from the next [`exchange`](Apparatus::exchange) on, or the measurement is a tick old.
    pub torque_late_ticks: f64,
    /// By how much an angle is older than the reading that brings it, s.
    pub angle_delay_s: f64,
    /// Most ticks in a row without new data.
    pub stale_limit: u32,
    /// Time without a command after which the amplifier itself removes the torque, s, as read back from it once it is
    /// prepared; `None` where the rig does not say.
    pub watchdog_s: Option<f64>,
    /// The device that only one run at a time may hold, whoever makes the run, as a path or an address; `None` for a rig without a device.
    pub device: Option<String>,
    /// The system calls that it makes in a tick.
    pub calls: DeclaredCalls,
    /// What its own codes mean, as a half sentence, which begins with the code where somebody else documents it.
    pub codes: Vec<(i32, String)>,
    /// Further facts worth keeping with a capture, as name and value.
    pub notes: Vec<(String, String)>,
}

impl RigDescription {
    /// Ticks at this rate by which the effect of a torque shows later than on a rig that reads and drives at the tick.
    #[must_use]
    pub fn late_ticks(&self, rate_hz: f64) -> f64 {
        // An angle that is dated later than its reading does not make the loop any faster.
        self.torque_late_ticks + (self.angle_delay_s * rate_hz).max(0.0)
    }

    /// The error in words, with the rig's name.
    #[must_use]
    pub fn explain(&self, error: ApparatusError) -> String {
        format!("the rig '{}': {}", self.name, error.reason(&self.codes))
    }

    /// The calibration for an analysis of the knob from this rig's torque, [with the rotor](Calibration::with_rotor) where there is no sensor.
    #[must_use]
    pub fn calibration_of_torque(&self) -> Calibration {
        match self.torque {
            TorqueSource::Sensor => self.calibration.clone(),
            TorqueSource::Motor => self.calibration.with_rotor(),
        }
    }
}

/// Why the apparatus could not do what was asked.
///
/// Plain data without heap, so that it can cross the real-time path; [`RigDescription::explain`] puts it into words.
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
    /// The rig reported a failure by a code of its own, never 0.
    #[error("the rig reported code {0}")]
    Device(i32),
    /// The amplifier's watchdog is slower than the rig file asks for.
    #[error("the amplifier's watchdog reads back longer than [watchdog] timeout_s; set it shorter, or say what it is")]
    SlowWatchdog,
    /// A stop was requested during preparation.
    #[error("stopped while the rig was prepared")]
    Stopped,
}

impl ApparatusError {
    /// The rig's own code, if it gave one.
    #[must_use]
    pub fn device_code(self) -> Option<i32> {
        match self {
            Self::Device(code) => Some(code),
            Self::Sensor | Self::Amplifier | Self::Watchdog | Self::SlowWatchdog | Self::Stopped => None,
        }
    }

    /// The error in words, of a rig whose codes have these meanings.
    #[must_use]
    pub fn reason(self, codes: &[(i32, String)]) -> String {
        let Self::Device(code) = self else { return self.to_string() };
        let meaning = codes.iter().find(|(known, _)| *known == code).map(|(_, meaning)| meaning.clone());
        // Manuals have some codes as they are and others in hexadecimal.
        let unknown =
            || format!("it reports code {code} ({code:#06x}), which nothing here explains; look it up in its manual");
        meaning.unwrap_or_else(unknown)
    }
}

/// A rig that turns a knob, through a torque sensor if it has one.
///
/// A run calls, in this order: [`prepare`](Self::prepare) on an ordinary thread, then on the real-time thread
/// [`enable`](Self::enable), once per tick [`exchange`](Self::exchange), [`shift_ns`](Self::shift_ns) and
/// [`write_torque`](Self::write_torque), and [`disable`](Self::disable) once at the end or at a fault, after which nothing is
/// called any more. What is called in a tick must not allocate, lock, log or block, and makes no system call but those that the
/// description declares. A rig whose process dies must go torque-free by itself (a watchdog in its amplifier).
pub trait Apparatus: Send {
    /// What the rig says of itself; watchdog, codes and notes may change by [`prepare`](Self::prepare), also where that fails.
    fn description(&self) -> &RigDescription;

    /// Prepares the rig so that it can be switched on at once: opens buses, finds the encoder's zero, arms the watchdog. This may
    /// take long, but must call `stop` several times a second and give up once `stop` returns true.
    ///
    /// # Errors
    /// [`ApparatusError`] when it does not come up; [`ApparatusError::Stopped`] when it gave up.
    fn prepare(&mut self, stop: &dyn Fn() -> bool) -> Result<(), ApparatusError> {
        let _ = stop;
        Ok(())
    }

    /// Switches the amplifier on, at zero torque, within a few ticks.
    ///
    /// # Errors
    /// [`ApparatusError`] when it does not come on.
    fn enable(&mut self) -> Result<(), ApparatusError>;

    /// Switches the amplifier off: torque-free from here on. Calling it again, or before it was on, does nothing.
    fn disable(&mut self);

    /// Reads the sensors at the tick that is due at `due_ns` (CLOCK_MONOTONIC, never falling), and gives the rig the torque of
    /// the tick before, mNm, unless [`write_torque`](Self::write_torque) has done so. A bus does both in one exchange.
    ///
    /// # Errors
    /// [`ApparatusError`] when a sensor or the amplifier has failed since the last call.
    fn exchange(&mut self, due_ns: u64, torque_mnm: f64) -> Result<Measurement, ApparatusError>;

    /// Sets the motor's torque until the next call, mNm. A rig that can take a torque between two exchanges implements this, which
    /// saves a period of delay; for other rigs the default does nothing.
    ///
    /// # Errors
    /// [`ApparatusError`] when the amplifier does not take it.
    fn write_torque(&mut self, torque_mnm: f64) -> Result<(), ApparatusError> {
        let _ = torque_mnm;
        Ok(())
    }

    /// By how much the ticks from the next one on are to come later than planned, ns; below zero for earlier. A bus that must be
    /// met in its own phase paces the loop by it. At most a tenth of a period is taken at a time.
    fn shift_ns(&self) -> i64 {
        0
    }

    /// What on this machine stands in its way, in sentences that say what to do; asked before it is prepared.
    fn obstacles(&self) -> Vec<String> {
        Vec::new()
    }
}
