//! The sensors' readings at rest.

use std::f64::consts::PI;

use dynamics::Calibration;

use super::estimate::{CalibrateError, Calibrated, Estimate};
use crate::numerics::statistics::{mean, mean_and_error, student_95};
use crate::samples::{FitError, span};

/// Travel up to which the rig counts as at rest, rad.
const REST_RAD: f64 = 2e-3;
/// Stretches whose means are compared: a drift slower than a stretch shows as scatter of the means.
const STRETCHES: usize = 30;
/// Steps that a signal must span for its variance to show its noise: on two levels the variance depends on where the mean lies between them.
const FEWEST_STEPS: f64 = 1.5;
/// Terms of the series for the quantisation bias: where the noise is so small that later terms matter, the bias is half a step.
const TERMS: u32 = 8;

/// Averages torque and acceleration of a rig at rest with nothing on the gripper.
///
/// Takes gravity from `known`, at the angle at which the rig rests; the interval does not include gravity's own
/// error. Returns `torque_zero_mnm` and, where there is an accelerometer, `acceleration_zero_rad_s2`.
///
/// # Errors
/// [`CalibrateError`] for a rig that moves.
pub fn zero(samples: &crate::Samples<'_>, known: &Calibration) -> Result<Calibrated, CalibrateError> {
    match samples.check() {
        Ok(()) | Err(FitError::NoMotion { .. } | FitError::ConstantTorque { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    let travel_rad = span(samples.angle_rad);
    if travel_rad > REST_RAD {
        return Err(CalibrateError::NotAtRest { travel_rad });
    }
    let mut calibrated = Calibrated::default();
    let mean_mnm = mean_at_rest(samples.torque_mnm, known.torque_step_mnm);
    calibrated.estimates.push(Estimate::new("torque_zero_mnm", mean_mnm, "mNm"));
    if let Some(acceleration) = samples.acceleration_rad_s2 {
        let own: Vec<f64> = acceleration
            .iter()
            .zip(samples.angle_rad)
            .map(|(seen, angle)| seen - known.gravity_rad_s2(*angle))
            .collect();
        let mean_rad_s2 = mean_at_rest(&own, known.acceleration_step_rad_s2);
        calibrated.estimates.push(Estimate::new("acceleration_zero_rad_s2", mean_rad_s2, "rad/s²"));
        calibrated.notes.push(format!(
            "acceleration_zero_rad_s2 is read beside a gravity of {:.1} rad/s²: it is as good as that is known",
            known.gravity_rad_s2(samples.angle_rad[0])
        ));
    }
    Ok(calibrated)
}

/// Mean of a signal at rest, and half the width of its 95 % interval.
///
/// The interval is that of the means of stretches, plus the bias that a coarse step may cause: the mean of a signal with Gaussian
/// noise σ on steps of Δ is off by at most Σ Δ/(πk)·exp(−2π²k²σ²/Δ²), k = 1, 2, …, and by Δ/2 (B. Widrow, I. Kollár,
/// *Quantization Noise*, 2008).
fn mean_at_rest(signal: &[f64], step: f64) -> (f64, f64) {
    let (value, own_error) = mean_and_error(signal);
    let stretch = signal.len() / STRETCHES;
    let means: Vec<f64> = signal.chunks_exact(stretch).take(STRETCHES).map(mean).collect();
    let (_, standard_error) = mean_and_error(&means);
    (value, student_95((means.len() - 1) as f64) * standard_error + bias_of_steps(signal, own_error, step))
}

/// Largest bias of the mean of a quantised signal: half a step where the signal spans too few steps for its variance to show its noise.
fn bias_of_steps(signal: &[f64], own_error: f64, step: f64) -> f64 {
    if step <= 0.0 {
        return 0.0;
    }
    if span(signal) < FEWEST_STEPS * step {
        return 0.5 * step;
    }
    let noise_variance = (signal.len() as f64 * own_error * own_error - step * step / 12.0).max(0.0);
    let term = |k: f64| (-2.0 * (PI * k).powi(2) * noise_variance / (step * step)).exp() / (PI * k);
    step * (1..=TERMS).map(|k| term(f64::from(k))).sum::<f64>().min(0.5)
}
