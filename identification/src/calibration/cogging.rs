//! The motor's cogging, from slow turns without a knob in both directions.
//!
//! The part of the command that neither reaches the torque sensor nor accelerates the motor is the motor's own torque: friction,
//! which changes its sign with the direction, and cogging, which does not:
//!
//! ```text
//! command − sensor − J·θ̈ = ±C + Σ H·sin(n·θ + η)
//! ```
//!
//! Turning both ways also cancels the effect of the delays of command and encoder on the phases.

use std::f64::consts::TAU;

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, CoggingEstimate};
use super::friction::motors_share_mnm;
use super::regression::Band;
use crate::Samples;
use crate::estimate::Harmonic;
use crate::numerics::derivative::gradient;
use crate::numerics::statistics::{half_width, median};
use crate::preparation::clock::whole;
use crate::preparation::uniform::Uniform;
use crate::samples::{FEWEST_SAMPLES, span};
use crate::sinusoids::matching_pursuit;

/// Band in which torque is compared with angle, Hz: well below the resonance of rotor and gripper.
const EDGE_HZ: f64 = 200.0;
/// Sinusoids are looked for up to this share of the band's edge, where the band's low-pass attenuates by 0.4 %.
const FINEST: f64 = 0.5;
/// Rows in a period of the band's edge.
const ROWS_PER_EDGE: f64 = 4.0;
/// Share of the usual speed below which the motor turns around.
const TURNING: f64 = 0.5;
/// Largest excess over the usual speed, as a share of it, with which a turn still counts as slow throughout.
const STEADY: f64 = 1.0;
/// Usual speed above which inertia and delays are no longer small beside cogging, rad/s.
const FASTEST_RAD_S: f64 = 3.0;

/// Finds the harmonics of the angle that stand out from the rest of the motor's torque.
///
/// `commanded_mnm` is the torque commanded at each sample, held until the next, including any compensation of the cogging. Takes
/// torque zero and motor inertia from `known`. Returns the harmonics of the motor's cogging, none for a motor without iron.
///
/// # Errors
/// [`CalibrateError`] for a capture of less than a turn, in one direction only, or not slow and steady.
pub fn cogging(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    known: &Calibration,
) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let refused = |reason: String| CalibrateError::NoCogging { reason };
    let travel_rad = span(samples.angle_rad);
    if travel_rad < TAU {
        return Err(refused(format!(
            "the motor turned through {:.0}°, less than a whole turn",
            travel_rad.to_degrees()
        )));
    }
    let taken_mnm = motors_share_mnm(samples, commanded_mnm, known)?;
    let uniform = Uniform::of(&Samples { torque_mnm: &taken_mnm, ..*samples }, known.axis, None);
    let rate_hz = uniform.rate_hz;
    let edge_hz = EDGE_HZ.min(0.2 * rate_hz);
    let band = Band { edge_hz, rate_hz };
    let angle_rad = band.smooth(&uniform.angle_rad);
    let velocity = gradient(&angle_rad, rate_hz);
    let acceleration = gradient(&velocity, rate_hz);
    let torque_mnm = band.smooth(&uniform.torque_mnm);
    let mut speeds: Vec<f64> = velocity.iter().map(|velocity| velocity.abs()).collect();
    let fastest_rad_s = speeds.iter().copied().fold(0.0, f64::max);
    let speed_rad_s = median(&mut speeds);
    if speed_rad_s > FASTEST_RAD_S || fastest_rad_s > (1.0 + STEADY) * speed_rad_s {
        return Err(refused(format!(
            "it turned with {speed_rad_s:.2} rad/s as a rule and {fastest_rad_s:.2} rad/s at most, not slowly and steadily"
        )));
    }
    let step = whole(rate_hz / (ROWS_PER_EDGE * edge_hz)).max(1);
    let is_steady = |row: &usize| uniform.present[*row] && velocity[*row].abs() > TURNING * speed_rad_s;
    let rows: Vec<usize> = (0..angle_rad.len()).step_by(step).filter(is_steady).collect();
    let at_rows = |of: &dyn Fn(usize) -> f64| rows.iter().map(|row| of(*row)).collect::<Vec<f64>>();
    let of_direction = |sign: f64| at_rows(&|row| if velocity[row].signum() == sign { sign } else { 0.0 });
    let base = vec![of_direction(-1.0), of_direction(1.0)];
    if base.iter().any(|column| column.iter().filter(|row| **row != 0.0).count() < FEWEST_SAMPLES) {
        return Err(refused("it turned in one direction only".to_owned()));
    }
    let motors_mnm = at_rows(&|row| torque_mnm[row] - known.motor_inertia * acceleration[row]);
    let finest = FINEST * edge_hz * TAU / speed_rad_s;
    let found = matching_pursuit::of_turns(base, &at_rows(&|row| angle_rad[row]), motors_mnm, finest)
        .ok_or_else(|| refused("friction and torques of the angle cannot be separated".to_owned()))?;
    let mut notes = Vec::new();
    if found.is_empty() {
        notes.push("no torque of the motor that repeats with its angle stands out: it has no cogging".to_owned());
    }
    Ok(Calibrated { cogging: Some(found.iter().map(estimated).collect()), notes, ..Calibrated::default() })
}

/// A harmonic of whole turns as a calibration has it.
fn estimated(harmonic: &Harmonic) -> CoggingEstimate {
    let half = |value, ci95: Option<[f64; 2]>| ci95.map_or(0.0, |ci95| half_width(value, ci95));
    CoggingEstimate {
        per_turn: harmonic.per_turn.round() as u32,
        torque_mnm: harmonic.amplitude_mnm,
        torque_half_width_mnm: half(harmonic.amplitude_mnm, harmonic.amplitude_ci95_mnm),
        phase_rad: harmonic.phase_rad,
        phase_half_width_rad: half(harmonic.phase_rad, harmonic.phase_ci95_rad),
    }
}
