//! The delays of torque and acceleration behind the encoder, to a fraction of a sample.
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
use crate::preparation::{Spectrum, Uniform, advance, gradient, knob_angle};

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
/// Takes gravity and the torque sensor's stiffness from `known`. Estimates `torque_delay_s` and, where
/// there is an accelerometer, `acceleration_delay_s`; a channel whose delay is not identifiable is a note.
///
/// # Errors
/// [`CalibrateError`] for samples that are no motion, or when neither channel follows it.
pub fn latency(samples: &Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let uniform = Uniform::of(samples, None);
    let rate_hz = uniform.rate_hz;
    let velocity = Spectrum::welch(&gradient(&uniform.angle_rad, rate_hz), rate_hz);
    let sweep_hz = velocity.power_below(0.95, 0.0);
    let edge_hz = (EDGE_PER_SWEEP * sweep_hz).max(LOWEST_EDGE_HZ).min(0.2 * rate_hz);
    let band = Band { edge_hz, rate_hz };
    let mut columns = vec![gradient(
        &gradient(&band.smooth(&knob_angle(&uniform.angle_rad, &uniform.torque_mnm, Some(known))), rate_hz),
        rate_hz,
    )];
    for order in 0..3 {
        columns.push(gradient(&columns[order], rate_hz));
    }
    columns.push(vec![1.0; uniform.angle_rad.len()]);

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
        if solved.unexplained > UNEXPLAINED {
            let error = CalibrateError::Unexplained {
                channel,
                percent: 100.0 * solved.unexplained,
                expected: "the motion of an inertia makes of it",
                remedy: "take the knob off, calibrate gravity first, and sweep faster",
            };
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
    let value = -slope / gain;
    (value, solved.half_width(&[slope / (gain * gain), -1.0 / gain, 0.0, 0.0, 0.0]))
}
