//! Torques at which a resting knob breaks away, read off the capture.

use dynamics::{Calibration, Direction};

use crate::numerics::statistics::mean;
use crate::preparation::clock::typical_step;
use crate::preparation::compliance::knob_angle_rad;
use crate::samples::{FitError, Samples};

/// Shortest rest before a breakaway, s.
const REST_S: f64 = 0.020;
/// … and fewest samples: the turning point of a motion has fewer.
const FEWEST_AT_REST: usize = 5;
/// Least rise of the torque during the rest, as a share of the breakaway torque: where a moving knob turns back, the torque hardly rises.
const RISE: f64 = 0.05;
/// Distance from its rest at which a knob has left it, in encoder steps …
const AWAY_STEPS: f64 = 6.0;
/// … or rad, where the encoder's step is not known.
const AWAY_RAD: f64 = 1e-4;
/// Time after the knob left its rest within which it must be ten times as far away, s; otherwise it creeps.
const SOON_S: f64 = 0.030;
/// Time before the knob leaves its rest in which the torque's peak is looked for, s.
const READ_S: f64 = 0.004;
/// Time over which the torque is averaged before its peak is taken, s.
const AVERAGE_S: f64 = 0.001;

/// One breakaway.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Breakaway {
    /// Time, s.
    pub t_s: f64,
    /// Angle at which the knob rested, rad.
    pub angle_rad: f64,
    /// Direction in which it broke away.
    pub direction: Direction,
    /// Torque on the knob as it broke away, mNm: without the sensor's zero, detents included.
    pub torque_mnm: f64,
}

/// Reads off the torques at which a resting knob breaks away.
///
/// A capture of slow ramps shows them best (`--torque --sweep torque-ramp`); any in which the knob rests
/// and slips will do. Takes zero, stiffness and encoder step from `known`.
///
/// # Errors
/// [`FitError`] for samples that are no capture of a motion.
pub fn breakaways(samples: &Samples<'_>, known: Option<&Calibration>) -> Result<Vec<Breakaway>, FitError> {
    samples.check()?;
    let rate_hz = 1.0 / typical_step(samples.t_s).0;
    let zero_mnm = known.map_or(0.0, |known| known.torque_zero_mnm);
    let knob_rad = knob_angle_rad(samples.angle_rad, samples.torque_mnm, known);
    let away_rad = known.map(|known| AWAY_STEPS * known.angle_step_rad).filter(|away| *away > 0.0).unwrap_or(AWAY_RAD);
    let lasting = |time_s: f64, fewest: usize| ((time_s * rate_hz).round() as usize).max(fewest);
    let (rest, soon) = (lasting(REST_S, FEWEST_AT_REST), lasting(SOON_S, 1));
    let (read, average) = (lasting(READ_S, 3), lasting(AVERAGE_S, 3));

    let mut found = Vec::new();
    let mut start = 0;
    for index in 1..knob_rad.len() {
        if (knob_rad[index] - knob_rad[start]).abs() <= away_rad {
            continue;
        }
        let rested = index - start;
        let later = (index + soon).min(knob_rad.len() - 1);
        let moved = knob_rad[later] - knob_rad[start];
        if rested >= rest && moved.abs() > 10.0 * away_rad {
            let direction = Direction::of(moved);
            let sign = direction.sign();
            // The torque falls once the knob slides, so its peak is the breakaway; a short mean keeps noise out of the peak.
            let peak = samples.torque_mnm[index - read..=index]
                .windows(average)
                .map(|part| sign * mean(part))
                .fold(f64::NEG_INFINITY, f64::max);
            let at_first = sign * mean(&samples.torque_mnm[start..start + average]);
            if peak - at_first > RISE * (peak - sign * zero_mnm).abs() {
                found.push(Breakaway {
                    t_s: samples.t_s[index],
                    angle_rad: knob_rad[start],
                    direction,
                    torque_mnm: sign * peak - zero_mnm,
                });
            }
        }
        start = index;
    }
    Ok(found)
}
