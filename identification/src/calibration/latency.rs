//! The delays of torque and acceleration behind the encoder, and of the motor behind its command, to a fraction of a sample.
//!
//! A channel that shows x late by D, its bandwidth limited, shows to third order
//!
//! ```text
//! y = g·(x − D·ẋ + c₂·ẍ − c₃·x⃛)
//! ```
//!
//! with x the angular acceleration from the encoder and g one, or the inertia. In frequencies this is
//! the cross spectrum's phase as −D·ω + c·ω³: D is its slope at frequency zero, which is the delay of
//! a slow signal, whatever the channel's filter. Solved as a regression it comes with an interval, and
//! all frequencies that the sweep excites take part by their weight.

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate};
use super::regression::{Band, Solved};
use crate::Samples;
use crate::preparation::compliance::knob_angle_rad;
use crate::preparation::motion::gradient;
use crate::preparation::spectrum::Spectrum;
use crate::preparation::uniform::{Uniform, advance};

/// The band reaches to this multiple of the frequency below which the motion's power lies …
const EDGE_PER_SWEEP: f64 = 1.5;
/// … but at least so far, Hz.
const LOWEST_EDGE_HZ: f64 = 25.0;
/// Share of a channel that may be something else.
const UNEXPLAINED: f64 = 0.5;
/// Longest delay that is believed, s.
const LONGEST_DELAY_S: f64 = 0.1;
/// Rounds of taking gravity out at the delayed angle.
const ROUNDS: usize = 3;

/// Fits the delays to a capture of the gripper alone (or any inertia without friction and detents).
///
/// Takes gravity and the torque sensor's stiffness from `known`. Tells `torque_delay_s` and, where
/// there is an accelerometer, `acceleration_delay_s`; a channel that cannot be estimated is a note.
///
/// # Errors
/// [`CalibrateError`] for samples that are no motion, or when neither channel follows it.
pub fn latency(samples: &Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let uniform = Uniform::of(samples, None);
    let band = band(&uniform);
    let columns = columns(&band, &knob_angle_rad(&uniform.angle_rad, &uniform.torque_mnm, Some(known)));
    let torque = band.solve(&columns, &band.smooth(&uniform.torque_mnm));
    let mut found = vec![("torque", "torque_delay_s", torque)];
    if let Some(acceleration) = &uniform.acceleration_rad_s2 {
        found.push((
            "acceleration",
            "acceleration_delay_s",
            acceleration_relation(&uniform, acceleration, known, &band, &columns),
        ));
    }
    let mut calibrated = Calibrated::default();
    let mut refusal = None;
    for (channel, quantity, solved) in found {
        if let Some(error) = unexplained(channel, &solved) {
            calibrated.notes.push(format!("no delay of the {channel}: {error}"));
            refusal.get_or_insert(error);
            continue;
        }
        let (value, half_width) = delay(&solved);
        calibrated.estimates.push(Estimate { quantity, value, half_width, unit: "s" });
    }
    match refusal {
        Some(error) if calibrated.estimates.is_empty() => Err(error),
        _ => Ok(calibrated),
    }
}

/// Fits the delay of the motor's torque behind its command to the same capture: what is commanded comes before the motion.
///
/// `commanded_mnm` is the torque commanded at each sample, which acts `late_ticks` later and is held for a tick. The motor's friction
/// is fitted with it. Tells `command_delay_s`: that of the motor in motion, whose back-EMF acts against its current, and so a little less
/// than its current loop's by itself.
///
/// # Errors
/// [`CalibrateError`] for samples that are no motion, and when the motion does not follow the command.
pub fn command_latency(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    late_ticks: f64,
) -> Result<Estimate, CalibrateError> {
    samples.check()?;
    if commanded_mnm.len() != samples.torque_mnm.len() || commanded_mnm.iter().any(|command| !command.is_finite()) {
        return Err(CalibrateError::NoCommand);
    }
    let driven = Samples { torque_mnm: commanded_mnm, acceleration_rad_s2: None, velocity_rad_s: None, ..*samples };
    let uniform = Uniform::of(&driven, None);
    let band = band(&uniform);
    let velocity = gradient(&band.smooth(&uniform.angle_rad), uniform.rate_hz);
    let direction: Vec<f64> = velocity.iter().map(|speed| speed.signum()).collect();
    let mut columns = columns(&band, &uniform.angle_rad);
    columns.extend([band.smooth(&direction), velocity]);
    let solved = band.solve(&columns, &band.smooth(&uniform.torque_mnm));
    if let Some(error) = unexplained("commanded torque", &solved) {
        return Err(error);
    }
    let (late_s, half_width) = delay(&solved);
    let value = -late_s - (late_ticks + 0.5) / uniform.rate_hz;
    Ok(Estimate { quantity: "command_delay_s", value, half_width, unit: "s" })
}

/// The band in which the motion lies.
fn band(uniform: &Uniform) -> Band {
    let rate_hz = uniform.rate_hz;
    let velocity = Spectrum::welch(&gradient(&uniform.angle_rad, rate_hz), rate_hz);
    let sweep_hz = velocity.power_below(0.95, 0.0);
    Band { edge_hz: (EDGE_PER_SWEEP * sweep_hz).max(LOWEST_EDGE_HZ).min(0.2 * rate_hz), rate_hz }
}

/// Acceleration, its three derivatives, and a constant.
fn columns(band: &Band, angle_rad: &[f64]) -> Vec<Vec<f64>> {
    let mut columns = vec![gradient(&gradient(&band.smooth(angle_rad), band.rate_hz), band.rate_hz)];
    for order in 0..3 {
        columns.push(gradient(&columns[order], band.rate_hz));
    }
    columns.push(vec![1.0; angle_rad.len()]);
    columns
}

/// Why a channel tells no delay, if it does not.
fn unexplained(channel: &'static str, solved: &Solved) -> Option<CalibrateError> {
    (solved.unexplained > UNEXPLAINED).then_some(CalibrateError::Unexplained {
        channel,
        percent: 100.0 * solved.unexplained,
        expected: "the motion of an inertia makes of it",
        remedy: "take the knob off, calibrate gravity first, and sweep faster",
    })
}

/// The accelerometer's relation, gravity taken out at the angle at which the sensor was read.
fn acceleration_relation(
    uniform: &Uniform,
    measured: &[f64],
    known: &Calibration,
    band: &Band,
    columns: &[Vec<f64>],
) -> Solved {
    let relation = |delay_s: f64| {
        let late = advance(&uniform.angle_rad, -delay_s * uniform.rate_hz);
        let own: Vec<f64> =
            measured.iter().zip(&late).map(|(seen, angle)| seen - known.gravity_rad_s2(*angle)).collect();
        band.solve(columns, &band.smooth(&own))
    };
    let mut solved = relation(known.acceleration_delay_s);
    for _ in 1..ROUNDS {
        let (delay_s, _) = delay(&solved);
        if !delay_s.is_finite() || delay_s.abs() > LONGEST_DELAY_S {
            break;
        }
        solved = relation(delay_s);
    }
    solved
}

/// Delay and half width of its 95 % interval, s.
fn delay(solved: &Solved) -> (f64, f64) {
    let [gain, slope] = [0, 1].map(|index| solved.coefficients[index]);
    let mut gradient = vec![0.0; solved.coefficients.len()];
    (gradient[0], gradient[1]) = (slope / (gain * gain), -1.0 / gain);
    (-slope / gain, solved.half_width(&gradient))
}
