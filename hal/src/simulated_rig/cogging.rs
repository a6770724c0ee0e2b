//! Cogging: the magnets of a motor pull its rotor towards the teeth of the iron.

use std::f64::consts::TAU;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::ParameterError;

/// One harmonic of the motor's cogging: what the rotor takes at an angle is torque · sin(periods · angle + phase).
///
/// A slotted motor cogs as many times a turn as the least common multiple of its slots and poles (Z. Q. Zhu and D. Howe,
/// *Influence of design parameters on cogging torque in permanent magnet machines*, IEEE Trans. Energy Conversion 15, 2000).
/// Manufacturing imperfections add harmonics with as many periods as there are slots, and as there are poles (L. Gašparin and
/// others, *Additional cogging torque components in permanent-magnet motors due to manufacturing imperfections*, IEEE Trans.
/// Magnetics 45, 2009).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cogging {
    /// Periods in a turn of the motor.
    pub per_turn: u32,
    /// Largest torque, mNm.
    pub torque_mnm: f64,
    /// Phase at the encoder's zero, rad.
    pub phase_rad: f64,
}

/// A text that is no cogging.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("'{0}' is no cogging; give periods per turn, mNm and, if it matters, rad, as in 48:1.5:0.3")]
pub struct CoggingError(String);

impl FromStr for Cogging {
    type Err = CoggingError;

    /// Reads `48:1.5` or `48:1.5:0.3`: periods per turn, mNm, rad.
    fn from_str(text: &str) -> Result<Self, CoggingError> {
        let invalid = || CoggingError(text.to_owned());
        let parts: Vec<&str> = text.split(':').collect();
        let (per_turn, torque, phase) = match parts[..] {
            [per_turn, torque] => (per_turn, torque, "0"),
            [per_turn, torque, phase] => (per_turn, torque, phase),
            _ => return Err(invalid()),
        };
        Ok(Self {
            per_turn: per_turn.parse().map_err(|_| invalid())?,
            torque_mnm: torque.parse().map_err(|_| invalid())?,
            phase_rad: phase.parse().map_err(|_| invalid())?,
        })
    }
}

/// Most periods in a turn: finer ones would pass the substeps of a fast motor.
const MOST_PER_TURN: u32 = 2000;

/// A motor's cogging, as the torque that holds its rotor back at `angle_rad`, mNm.
pub(super) fn cogging_mnm(harmonics: &[Cogging], angle_rad: f64) -> f64 {
    let turns = angle_rad / TAU;
    harmonics
        .iter()
        // Within a turn a sine loses no digits, however far the motor has gone.
        .map(|harmonic| {
            let periods = f64::from(harmonic.per_turn) * (turns - turns.floor());
            harmonic.torque_mnm * (TAU * periods + harmonic.phase_rad).sin()
        })
        .sum()
}

/// Checks that the numbers describe a motor.
pub(super) fn validate(harmonics: &[Cogging]) -> Result<(), ParameterError> {
    for harmonic in harmonics {
        if !(1..=MOST_PER_TURN).contains(&harmonic.per_turn) {
            let value = f64::from(harmonic.per_turn);
            return Err(ParameterError { parameter: "motor_cogging's per_turn", value, requirement: "from 1 to 2000" });
        }
        for (parameter, value) in
            [("motor_cogging's torque_mnm", harmonic.torque_mnm), ("motor_cogging's phase_rad", harmonic.phase_rad)]
        {
            if !value.is_finite() {
                return Err(ParameterError { parameter, value, requirement: "finite" });
            }
        }
    }
    Ok(())
}
