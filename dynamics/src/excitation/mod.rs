//! Excitations: the motions and torques with which a knob is probed.
//!
//! An [`Excitation`] is plain data without heap, so that a real-time loop can own one, and a pure
//! function of time: after missed ticks it goes on as if none had been missed.

mod chirp;
mod jet;
mod multisine;
mod slow_turn;
mod stepped;
mod torque_ramp;

use serde::{Deserialize, Serialize};

use crate::Axis;

pub use chirp::{ChirpForm, ChirpSweep};
use jet::Jet;
pub use multisine::Multisine;
pub use slow_turn::SlowTurn;
pub use stepped::SteppedAmplitude;
pub use torque_ramp::TorqueRamp;

/// What an excitation commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Drive {
    /// An angle, which the position servo follows.
    Position,
    /// A torque of the motor.
    Torque,
}

/// The commanded value at one moment, with its first two derivatives by time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Angle in rad, or torque in mNm.
    pub value: f64,
    /// Its rate, per s.
    pub rate: f64,
    /// Its second derivative, per s².
    pub acceleration: f64,
}

/// The shape of an excitation over time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "shape", rename_all = "kebab-case")]
pub enum Shape {
    /// The paper's swept sine (equation 2), as printed or as a linear chirp.
    Chirp(ChirpSweep),
    /// Many sines at once.
    Multisine(Multisine),
    /// Sweeps whose amplitude rises step by step.
    SteppedAmplitude(SteppedAmplitude),
    /// A slow turn there and back.
    SlowTurn(SlowTurn),
    /// Ramps that rise until the knob breaks away.
    TorqueRamp(TorqueRamp),
    /// No excitation: the start position held, or no torque.
    Hold,
}

/// A commanded angle or torque as a function of time.
///
/// ```
/// use dynamics::{Drive, Excitation};
///
/// let sweep = Excitation::named("linear-chirp", Drive::Position)?;
/// let quarter = sweep.at(1.0); // 0.5·t Hz: phase π/2 after one second
/// assert!((quarter.value - 1.0).abs() < 1e-12);
/// # Ok::<(), dynamics::excitation::ExcitationError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Excitation {
    /// Whether angle or torque is commanded.
    pub drive: Drive,
    /// Largest commanded value, rad or mNm.
    pub amplitude: f64,
    /// Whether it goes one way from the start and back, as what is pressed does: where a shape goes both ways, its square is taken.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_one_sided: bool,
    /// The shape over time.
    #[serde(flatten)]
    pub shape: Shape,
}

/// Why there is no such excitation.
#[derive(Debug, thiserror::Error)]
pub enum ExcitationError {
    /// A name that is not among the known ones.
    #[error("there is no sweep '{name}'; choose one of {}", NAMES.join(", "))]
    UnknownName {
        /// The name asked for.
        name: String,
    },
    /// An amplitude that is not a positive number.
    #[error("the sweep's amplitude is {amplitude}, but it must be more than zero, and finite")]
    Amplitude {
        /// The amplitude asked for.
        amplitude: f64,
    },
}

/// The names of the excitations, as the command line takes them.
pub const NAMES: [&str; 9] = [
    "paper",
    "linear-chirp",
    "multisine",
    "fast-multisine",
    "stepped-amplitude",
    "slow-turn",
    "torque-ramp",
    "tone",
    "hold",
];

/// Amplitude in rad of a position excitation by default: the paper's c.
pub const POSITION_AMPLITUDE_RAD: f64 = 1.0;
/// Amplitude in mNm of a torque excitation by default: the paper's 0.02 Nm.
pub const TORQUE_AMPLITUDE_MNM: f64 = 20.0;
/// How far a position excitation presses by default, mm: to the bottom of a dome, and not much beyond.
pub const PRESSED_MM: f64 = 3.4;
/// Amplitude in rad of `fast-multisine` and `tone` by default: what the rig follows at their frequencies.
pub const FAST_AMPLITUDE_RAD: f64 = 0.05;

impl Excitation {
    /// The excitation called `name` with its usual constants: the paper's, where it has the excitation.
    ///
    /// # Errors
    /// [`ExcitationError::UnknownName`] for a name not in [`NAMES`].
    pub fn named(name: &str, drive: Drive) -> Result<Self, ExcitationError> {
        let shape = match name {
            "paper" => Shape::Chirp(ChirpSweep::paper()),
            "linear-chirp" => Shape::Chirp(ChirpSweep::linear()),
            "multisine" => Shape::Multisine(Multisine::default()),
            "fast-multisine" => Shape::Multisine(Multisine::fast()),
            "stepped-amplitude" => Shape::SteppedAmplitude(SteppedAmplitude::default()),
            "slow-turn" => Shape::SlowTurn(SlowTurn::default()),
            "torque-ramp" => Shape::TorqueRamp(TorqueRamp::default()),
            "tone" => Shape::Multisine(Multisine::tone()),
            "hold" => Shape::Hold,
            _ => {
                return Err(ExcitationError::UnknownName { name: name.to_owned() });
            }
        };
        let amplitude = match (drive, name) {
            (Drive::Position, "slow-turn") => SlowTurn::TURNS * std::f64::consts::TAU,
            (Drive::Position, "fast-multisine" | "tone") => FAST_AMPLITUDE_RAD,
            (Drive::Position, _) => POSITION_AMPLITUDE_RAD,
            (Drive::Torque, _) => TORQUE_AMPLITUDE_MNM,
        };
        Ok(Self { drive, amplitude, is_one_sided: false, shape })
    }

    /// This excitation on `axis`. On a linear axis it presses and lets go: by the travel of a fingertip on the knob, at most
    /// [`PRESSED_MM`], or by the force of a fingertip on the knob.
    #[must_use]
    pub fn on(self, axis: Axis) -> Self {
        if axis.is_rotary() {
            return self;
        }
        let amplitude = match self.drive {
            Drive::Position => PRESSED_MM.min(self.amplitude * axis.fingertip_travel()),
            Drive::Torque => self.amplitude / axis.fingertip_travel(),
        };
        let shape = match self.shape {
            // The square of a sine has twice its frequency.
            Shape::Multisine(tone) if tone.tones == 1 => {
                Shape::Multisine(Multisine { base_hz: 0.5 * tone.base_hz, ..tone })
            }
            shape => shape,
        };
        Self { amplitude, is_one_sided: true, shape, ..self }
    }

    /// The same excitation with another amplitude, in rad or mNm.
    ///
    /// # Errors
    /// [`ExcitationError::Amplitude`] unless it is finite and above zero.
    pub fn with_amplitude(self, amplitude: f64) -> Result<Self, ExcitationError> {
        if amplitude.is_finite() && amplitude > 0.0 {
            Ok(Self { amplitude, ..self })
        } else {
            Err(ExcitationError::Amplitude { amplitude })
        }
    }

    /// The commanded value at `time_s` after the start, with its derivatives.
    ///
    /// Starts from zero; value and rate are continuous.
    #[must_use]
    pub fn at(&self, time_s: f64) -> Setpoint {
        let unit = match &self.shape {
            Shape::Chirp(sweep) => sweep.at(time_s),
            Shape::Multisine(sum) => sum.at(time_s),
            Shape::SteppedAmplitude(steps) => steps.at(time_s),
            Shape::SlowTurn(turn) => turn.at(time_s),
            Shape::TorqueRamp(ramp) => ramp.at(time_s),
            Shape::Hold => Jet::constant(0.0),
        };
        let unit = match self.shape {
            // They go one way from zero by themselves.
            Shape::SlowTurn(_) | Shape::Hold => unit,
            _ if self.is_one_sided => unit * unit,
            _ => unit,
        };
        Setpoint {
            value: self.amplitude * unit.value,
            rate: self.amplitude * unit.first,
            acceleration: self.amplitude * unit.second,
        }
    }
}
