//! Cogging of the simulated rig's motor, as an option gives it: `48:1.5` or `48:1.5:0.3`.

use std::fmt;
use std::str::FromStr;

use hal::simulated::Cogging;

/// One harmonic of the cogging that the simulated rig's motor is to have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorCogging(pub Cogging);

impl FromStr for MotorCogging {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let told =
            || format!("'{text}' is no cogging; give periods per turn, mNm and, if it matters, rad, as in 48:1.5:0.3");
        let parts: Vec<&str> = text.split(':').collect();
        let (per_turn, torque, phase) = match parts[..] {
            [per_turn, torque] => (per_turn, torque, "0"),
            [per_turn, torque, phase] => (per_turn, torque, phase),
            _ => return Err(told()),
        };
        Ok(Self(Cogging {
            per_turn: per_turn.parse().map_err(|_| told())?,
            torque_mnm: torque.parse().map_err(|_| told())?,
            phase_rad: phase.parse().map_err(|_| told())?,
        }))
    }
}

impl fmt::Display for MotorCogging {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Cogging { per_turn, torque_mnm, phase_rad } = self.0;
        write!(f, "{per_turn}:{torque_mnm}:{phase_rad}")
    }
}
