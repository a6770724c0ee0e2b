//! The delays of torque and acceleration behind the encoder, and of the motor behind its command, to a fraction of a sample.
//!
//! A channel of limited bandwidth that shows x with the delay D shows, to third order,
//!
//! ```text
//! y = g·(x − D·ẋ + c₂·ẍ − c₃·x⃛)
//! ```
//!
//! where x is the angular acceleration from the encoder, and g is one for an accelerometer and the inertia
//! for a torque. The phase of the cross spectrum is then −D·ω + c·ω³: minus D is its slope at frequency zero,
//! and D is the delay of a slow signal, whatever the channel's filter. The regression gives D with an
//! interval and weights every frequency that the sweep excites by its power.

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate, check_command};
use super::regression::{Band, Solved, UNEXPLAINED};
use crate::Samples;
use crate::numerics::derivative::gradient;
use crate::numerics::interpolation::advance;
use crate::numerics::statistics::rms;
use crate::preparation::compliance::knob_angle_rad;
use crate::preparation::spectrum::Spectrum;
use crate::preparation::uniform::Uniform;

/// The band reaches to this multiple of the frequency below which the motion's power lies …
const EDGE_PER_SWEEP: f64 = 1.5;
/// … but at least so far, Hz.
const LOWEST_EDGE_HZ: f64 = 25.0;
/// Longest delay that is believed, s.
const LONGEST_DELAY_S: f64 = 0.1;
/// Iterations in which gravity or friction is evaluated at the motion delayed by the last estimate.
const ROUNDS: usize = 3;
/// Half widths of their intervals by which coefficients of friction must differ from zero to be kept.
const SIGNIFICANT: f64 = 2.0;
/// Share of the torque from which friction behind the sensor is worth a note.
const MUCH_FRICTION: f64 = 0.05;

/// Fits the delays to a capture of the gripper alone (or any inertia without detents; friction behind the sensor is fitted with it).
///
/// Takes gravity and the torque sensor's stiffness from `known`. Returns `torque_delay_s` and, where
/// there is an accelerometer, `acceleration_delay_s`; a delay that cannot be estimated is replaced by a note.
///
/// # Errors
/// [`CalibrateError`] for samples that are no motion, or when neither channel follows it.
pub fn latency(samples: &Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let uniform = Uniform::of(samples, known.axis, None);
    let band = band(&uniform);
    let knob_rad = knob_angle_rad(&uniform.angle_rad, &uniform.torque_mnm, Some(known));
    let columns = columns(&band, &knob_rad);
    let (torque, note) = torque_relation(&uniform, known, &band, &columns, &knob_rad);
    let mut calibrated = Calibrated { notes: note.into_iter().collect(), ..Calibrated::default() };
    let mut found = vec![("torque", "torque_delay_s", torque)];
    if let Some(acceleration) = &uniform.acceleration_rad_s2 {
        found.push((
            "acceleration",
            "acceleration_delay_s",
            acceleration_relation(&uniform, acceleration, known, &band, &columns),
        ));
    }
    let mut refusal = None;
    for (channel, quantity, solved) in found {
        if let Some(error) = unexplained(channel, &solved) {
            calibrated.notes.push(format!("no delay of the {channel}: {error}"));
            refusal.get_or_insert(error);
            continue;
        }
        calibrated.estimates.push(Estimate::new(quantity, delay(&solved), "s"));
    }
    match refusal {
        Some(error) if calibrated.estimates.is_empty() => Err(error),
        _ => Ok(calibrated),
    }
}

/// Fits the delay of the motor's torque behind its command to the capture that [`latency`] takes: a command precedes its motion.
///
/// `commanded_mnm` is the torque commanded at each sample, which acts `late_ticks` later and is held for a tick. The motor's friction
/// is fitted too. Returns `command_delay_s`, the delay of the motor in motion: its back-EMF opposes its current, so that the delay is a
/// little shorter than that of the current loop alone.
///
/// # Errors
/// [`CalibrateError`] for samples that are no motion, and when the motion does not follow the command.
pub fn command_latency(
    samples: &Samples<'_>,
    commanded_mnm: &[f64],
    late_ticks: f64,
    known: &Calibration,
) -> Result<Estimate, CalibrateError> {
    samples.check()?;
    check_command(samples, commanded_mnm)?;
    let driven = Samples { torque_mnm: commanded_mnm, acceleration_rad_s2: None, velocity_rad_s: None, ..*samples };
    let uniform = Uniform::of(&driven, known.axis, None);
    let band = band(&uniform);
    let velocity = gradient(&band.smooth(&uniform.angle_rad), uniform.rate_hz);
    let mut columns = columns(&band, &uniform.angle_rad);
    columns.extend(friction_columns(&band, velocity));
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

/// The direction of a motion, and its velocity.
fn friction_columns(band: &Band, velocity: Vec<f64>) -> [Vec<f64>; 2] {
    let direction: Vec<f64> = velocity.iter().map(|speed| speed.signum()).collect();
    [band.smooth(&direction), velocity]
}

/// The error for a channel that the motion does not explain; `None` if the motion explains enough of it.
fn unexplained(channel: &'static str, solved: &Solved) -> Option<CalibrateError> {
    let remedy = "take the knob off, calibrate gravity first, and sweep faster";
    solved.unexplained(channel, "the motion of an inertia makes of it", remedy)
}

/// Solves by fixed-point iteration a relation that depends in part on the delay it determines.
fn at_its_delay(first_s: f64, relation: impl Fn(f64) -> Solved) -> Solved {
    let mut solved = relation(first_s);
    for _ in 1..ROUNDS {
        let (delay_s, _) = delay(&solved);
        if !delay_s.is_finite() || delay_s.abs() > LONGEST_DELAY_S {
            break;
        }
        solved = relation(delay_s);
    }
    solved
}

/// Solves the torque sensor's relation together with the friction behind the sensor, a torque in phase with the velocity that would
/// otherwise look like a delay. Also returns a note if that friction is large and the delay can still be estimated.
fn torque_relation(
    uniform: &Uniform,
    known: &Calibration,
    band: &Band,
    columns: &[Vec<f64>],
    knob_rad: &[f64],
) -> (Solved, Option<String>) {
    let target = band.smooth(&uniform.torque_mnm);
    let velocity = gradient(&band.smooth(knob_rad), uniform.rate_hz);
    let friction = |delay_s: f64| friction_columns(band, advance(&velocity, -delay_s * uniform.rate_hz));
    let mut solved = at_its_delay(known.torque_delay_s, |delay_s| {
        band.solve(&columns.iter().cloned().chain(friction(delay_s)).collect::<Vec<_>>(), &target)
    });
    let places = [columns.len(), columns.len() + 1];
    let is_significant = |place: &usize| {
        let mut derivatives = vec![0.0; columns.len() + 2];
        derivatives[*place] = 1.0;
        solved.coefficients[*place].abs() > SIGNIFICANT * solved.half_width(&derivatives)
    };
    // Columns of a friction that is not significant would only widen the interval.
    if !places.iter().any(is_significant) {
        return (band.solve(columns, &target), None);
    }
    let [coulomb_mnm, viscous] = places.map(|place| solved.coefficients[place]);
    let [direction, velocity] = friction(delay(&solved).0);
    let torque: Vec<f64> =
        direction.iter().zip(&velocity).map(|(sign, speed)| coulomb_mnm * sign + viscous * speed).collect();
    let share = rms(&torque) / solved.target_deviation;
    // Friction is no part of an inertia's relation: its share of the torque counts as unexplained.
    solved.unexplained = solved.unexplained.hypot(share);
    let note = || {
        format!(
            "friction behind the torque sensor, {coulomb_mnm:.2} mNm and {viscous:.3} mNm·s/rad, makes {:.0} % of the torque: it was \
             fitted along, but a delay is exact with nothing on the gripper",
            100.0 * share
        )
    };
    let note = (share > MUCH_FRICTION && solved.unexplained <= UNEXPLAINED).then(note);
    (solved, note)
}

/// The accelerometer's relation, gravity taken out at the angle at which the sensor was read.
fn acceleration_relation(
    uniform: &Uniform,
    measured: &[f64],
    known: &Calibration,
    band: &Band,
    columns: &[Vec<f64>],
) -> Solved {
    at_its_delay(known.acceleration_delay_s, |delay_s| {
        let late = advance(&uniform.angle_rad, -delay_s * uniform.rate_hz);
        let own: Vec<f64> =
            measured.iter().zip(&late).map(|(seen, angle)| seen - known.gravity_rad_s2(*angle)).collect();
        band.solve(columns, &band.smooth(&own))
    })
}

/// Delay and half width of its 95 % interval, s.
fn delay(solved: &Solved) -> (f64, f64) {
    let [gain, slope] = [0, 1].map(|index| solved.coefficients[index]);
    let mut gradient = vec![0.0; solved.coefficients.len()];
    (gradient[0], gradient[1]) = (slope / (gain * gain), -1.0 / gain);
    (-slope / gain, solved.half_width(&gradient))
}
