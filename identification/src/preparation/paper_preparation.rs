//! The preparation of Swindells and MacLean 2007, for comparison.

use super::filter::{Fir, butterworth_low_pass, chebyshev2_low_pass};
use super::fixed_preparation::FixedPreparation;
use super::motion::{Band, KnobMotion, gradient, prompt};
use super::row_filter::RowFilter;
use super::uniform::Uniform;
use crate::uncertainty::statistics::rms;

/// Order and stop band of the Chebyshev low-passes of the second kind, dB.
const CHEBYSHEV: (usize, f64) = (3, 20.0);
/// Edges for angle and velocity, Hz.
const MOTION_EDGE_HZ: f64 = 1000.0;
/// Edges for acceleration and torque, Hz.
const TORQUE_EDGE_HZ: f64 = 500.0;
/// Order and edge of the Butterworth low-pass on the velocity; the paper does not print the edge, Hz.
const BUTTERWORTH: (usize, f64) = (10, 500.0);
/// Highest edge as a share of the sample rate.
const HIGHEST: f64 = 0.45;
/// Speed below which a sample counts as stuck, as a share of the RMS speed.
const SLOW: f64 = 0.01;

/// Motion, torque and rows as the paper prepares them.
pub(crate) fn paper_preparation(uniform: &Uniform) -> FixedPreparation {
    let rate_hz = uniform.rate_hz;
    let angle = chebyshev(&uniform.angle_rad, MOTION_EDGE_HZ, rate_hz);
    let rough = gradient(&uniform.angle_rad, rate_hz);
    let smooth = butterworth_low_pass(BUTTERWORTH.0, BUTTERWORTH.1.min(HIGHEST * rate_hz), rate_hz)
        .map_or(rough.clone(), |sections| sections.filter_zero_phase(&rough));
    let velocity = chebyshev(&smooth, MOTION_EDGE_HZ, rate_hz);
    let sensor = uniform.acceleration_rad_s2.as_ref();
    let acceleration = sensor
        .map_or_else(|| gradient(&velocity, rate_hz), |sensor| prompt(sensor, uniform.acceleration_lag_s, rate_hz));
    let threshold_rad_s = SLOW * rms(&velocity);
    let mask = velocity
        .iter()
        .zip(&uniform.present)
        .map(|(velocity, present)| f64::from(*present && velocity.abs() > threshold_rad_s))
        .collect();
    let columns = [uniform.time_s.clone(), angle, velocity, chebyshev(&acceleration, TORQUE_EDGE_HZ, rate_hz)];
    let motion = KnobMotion {
        exact: false,
        accelerometer: sensor.is_some(),
        lag_s: uniform.acceleration_lag_s,
        equal_hz: 0.0,
        ..KnobMotion::as_given(columns, TORQUE_EDGE_HZ.min(HIGHEST * rate_hz))
    };
    let edge_hz = TORQUE_EDGE_HZ.min(HIGHEST * rate_hz);
    FixedPreparation {
        motion,
        torque_mnm: chebyshev(&uniform.torque_mnm, TORQUE_EDGE_HZ, rate_hz),
        row_filter: RowFilter { rate_hz, mask, fir: Fir::identity(), step: 1, threshold_rad_s, response: None },
        band: Band::fixed(edge_hz, (uniform.torque_density * 0.5 * rate_hz).sqrt()),
    }
}

fn chebyshev(signal: &[f64], edge_hz: f64, rate_hz: f64) -> Vec<f64> {
    chebyshev2_low_pass(CHEBYSHEV.0, CHEBYSHEV.1, edge_hz.min(HIGHEST * rate_hz), rate_hz)
        .map_or_else(|_| signal.to_vec(), |sections| sections.filter_zero_phase(signal))
}
