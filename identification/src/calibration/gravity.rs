//! Gravity in the acceleration signal, from a slow turn.
//!
//! An accelerometer beside the axis sees gravity as a sine once per turn:
//!
//! ```text
//! a(t) = zero + G·sin(θ + φ) + θ̈
//! ```
//!
//! The last term is the encoder's second derivative, taken out in the band in which the encoder is far
//! quieter than the accelerometer, so that accelerations caused by detents and stick do not disturb the sine.

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate};
use super::regression::Band;
use crate::Samples;
use crate::numerics::derivative::gradient;
use crate::numerics::lag::prompt;
use crate::preparation::compliance::knob_angle_rad;
use crate::preparation::uniform::Uniform;
use crate::samples::span;

/// Upper edge of the comparison, Hz: above the frequencies of a slow turn, below those at which the encoder gets noisy.
const EDGE_HZ: f64 = 40.0;

/// Fits zero, amplitude and phase of gravity to a turn of at least 360°.
///
/// Takes the acceleration's delay and the torque sensor's stiffness from `known`. Returns
/// `gravity_amplitude_rad_s2`, `gravity_phase_rad` and `acceleration_zero_rad_s2`.
///
/// # Errors
/// [`CalibrateError`] for a capture without accelerometer, of less than a turn, or without gravity in it.
pub fn gravity(samples: &Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    samples.check()?;
    let travel_rad = span(samples.angle_rad);
    if travel_rad < std::f64::consts::TAU {
        return Err(CalibrateError::LessThanATurn { travel_rad });
    }
    // Only the delay is taken out: zero and gravity, the rest of the acceleration's correction, are to be fitted.
    let delays = Calibration { acceleration_zero_rad_s2: 0.0, gravity_amplitude_rad_s2: 0.0, ..known.clone() };
    let uniform = Uniform::of(samples, known.axis, Some(&delays));
    let Some(measured) = &uniform.acceleration_rad_s2 else { return Err(CalibrateError::NoAcceleration) };
    let measured = prompt(measured, uniform.acceleration_lag_s, uniform.rate_hz);
    let band = Band { edge_hz: EDGE_HZ.min(0.2 * uniform.rate_hz), rate_hz: uniform.rate_hz };

    let angle_rad = band.smooth(&knob_angle_rad(&uniform.angle_rad, &uniform.torque_mnm, Some(known)));
    let acceleration = gradient(&gradient(&angle_rad, uniform.rate_hz), uniform.rate_hz);
    let target: Vec<f64> = band.smooth(&measured).iter().zip(&acceleration).map(|(seen, own)| seen - own).collect();
    let columns = [
        vec![1.0; angle_rad.len()],
        angle_rad.iter().map(|angle| angle.sin()).collect(),
        angle_rad.iter().map(|angle| angle.cos()).collect(),
    ];
    let solved = band.solve(&columns, &target);
    let expected = "gravity and the knob's own acceleration make of it";
    let remedy = "check the accelerometer, and turn more slowly";
    if let Some(error) = solved.unexplained("acceleration", expected, remedy) {
        return Err(error);
    }
    let [zero, sine, cosine] = [0, 1, 2].map(|index| solved.coefficients[index]);
    let amplitude = sine.hypot(cosine);
    let estimate = |quantity, value, unit, derivatives: [f64; 3]| {
        Estimate::new(quantity, (value, solved.half_width(&derivatives)), unit)
    };
    let square = amplitude * amplitude;
    Ok(Calibrated {
        estimates: vec![
            estimate("gravity_amplitude_rad_s2", amplitude, "rad/s²", [0.0, sine / amplitude, cosine / amplitude]),
            estimate("gravity_phase_rad", cosine.atan2(sine), "rad", [0.0, -cosine / square, sine / square]),
            estimate("acceleration_zero_rad_s2", zero, "rad/s²", [1.0, 0.0, 0.0]),
        ],
        ..Calibrated::default()
    })
}
