//! The motor's cogging, taken out by its calibration.

use dynamics::{Calibration, CoggingHarmonic};

/// Torque that makes the motor turn as if it had no cogging.
///
/// It depends on the angle alone, so that it acts at rest too. A command waits for its tick on some rigs, is held over a tick and reaches the
/// shaft late by the amplifier's delay, so the torque is computed at the angle that the rotor will have by then. Computed at the reading's angle, it
/// would leave a twentieth of a cogging of 48 periods a turn, at 10 kHz and 10 rad/s, and a part of that would drive the rotor.
#[derive(Clone, Debug)]
pub struct CoggingCompensation {
    harmonics: Box<[CoggingHarmonic]>,
    /// Time from a reading to the middle of the interval in which its command acts, s.
    lead_s: f64,
}

impl CoggingCompensation {
    /// The compensation of the cogging in a calibration, at a sample rate and for torques that begin to act so many ticks later; no torque
    /// where the calibration has none.
    #[must_use]
    pub fn new(calibration: &Calibration, rate_hz: f64, torque_late_ticks: f64) -> Self {
        Self {
            harmonics: calibration.motor_cogging.as_deref().unwrap_or_default().into(),
            lead_s: (torque_late_ticks + 0.5) / rate_hz + calibration.command_delay_s.unwrap_or(0.0),
        }
    }

    /// The torque to add to a command for a rotor that is read at `angle_rad` and turns with `velocity_rad_s`, mNm.
    #[must_use]
    pub fn torque_mnm(&self, angle_rad: f64, velocity_rad_s: f64) -> f64 {
        let ahead_rad = angle_rad + self.lead_s * velocity_rad_s;
        let mut torque_mnm = 0.0;
        for harmonic in &self.harmonics {
            torque_mnm += harmonic.at_mnm(ahead_rad);
        }
        torque_mnm
    }
}
