//! Preparations whose filters do not depend on the data, for comparison with what others publish.

use super::Prepared;
use super::band::Band;
use super::filter::{Fir, both_ways, chebyshev1_low_pass, chebyshev2_low_pass, low_pass};
use super::motion::KnobMotion;
use super::row_filter::{RowFilter, SLOW};
use super::uniform::Uniform;
use crate::numerics::derivative::gradient;
use crate::numerics::lag::prompt;
use crate::numerics::statistics::rms;

/// Highest edge as a share of the sample rate.
const HIGHEST: f64 = 0.45;

/// Order and stop band (dB) of the paper's Chebyshev low-passes of the second kind.
const PAPER_CHEBYSHEV: (usize, f64) = (3, 20.0);
/// Their edges for angle and velocity, Hz, …
const MOTION_EDGE_HZ: f64 = 1000.0;
/// … and for acceleration and torque, Hz.
const TORQUE_EDGE_HZ: f64 = 500.0;
/// Order and edge of the Butterworth low-pass on the velocity; the paper does not print the edge, Hz.
const PAPER_BUTTERWORTH: (usize, f64) = (10, 500.0);

/// Order and edge (Hz) of the Butterworth low-pass on the angle before central differences, run both ways.
const BUTTERWORTH: (usize, f64) = (4, 100.0);
/// Order, ripple (dB) and edge (Hz) of the Chebyshev low-pass of the first kind before decimation, run both ways: what
/// `decimate` of MATLAB and scipy takes by default.
const CHEBYSHEV: (usize, f64, f64) = (8, 0.05, 40.0);
/// The edge as a share of half the sample rate after decimation.
const EDGE_SHARE: f64 = 0.8;
/// Time that is cut off at each end, where filter and differences are unsettled, s.
const CUT_S: f64 = 0.05;
/// Half length over which the low-pass before decimation has rung out to 10⁻⁶, in periods of its edge.
const RINGING_PERIODS: f64 = 24.0;

/// Motion, torque and rows as Swindells and MacLean (2007) prepare them.
pub(crate) fn paper(uniform: &Uniform) -> Prepared<'static> {
    let rate_hz = uniform.rate_hz;
    let (order, stop_db) = PAPER_CHEBYSHEV;
    let chebyshev = |signal: &[f64], edge_hz: f64| {
        both_ways(chebyshev2_low_pass(order, stop_db, edge_hz.min(HIGHEST * rate_hz), rate_hz), signal)
    };
    let (order, edge_hz) = PAPER_BUTTERWORTH;
    let rough = gradient(&uniform.angle_rad, rate_hz);
    let velocity = chebyshev(&low_pass(order, edge_hz.min(HIGHEST * rate_hz), rate_hz, &rough), MOTION_EDGE_HZ);
    let sensor = uniform.acceleration_rad_s2.as_ref();
    let acceleration = sensor
        .map_or_else(|| gradient(&velocity, rate_hz), |sensor| prompt(sensor, uniform.acceleration_lag_s, rate_hz));
    let threshold_rad_s = SLOW * rms(&velocity);
    let mask = velocity
        .iter()
        .zip(&uniform.present)
        .map(|(velocity, present)| f64::from(*present && velocity.abs() > threshold_rad_s))
        .collect();
    let angle = chebyshev(&uniform.angle_rad, MOTION_EDGE_HZ);
    let columns = [uniform.time_s.clone(), angle, velocity, chebyshev(&acceleration, TORQUE_EDGE_HZ)];
    let edge_hz = TORQUE_EDGE_HZ.min(HIGHEST * rate_hz);
    let motion = KnobMotion {
        exact: false,
        accelerometer: sensor.is_some(),
        lag_s: uniform.acceleration_lag_s,
        equal_hz: 0.0,
        ..KnobMotion::as_given(columns, edge_hz)
    };
    Prepared {
        motion,
        torque_mnm: chebyshev(&uniform.torque_mnm, TORQUE_EDGE_HZ).into(),
        row_filter: RowFilter { rate_hz, mask, fir: Fir::identity(), step: 1, threshold_rad_s, response: None },
        band: Band::fixed(edge_hz, uniform.torque_noise_mnm()),
    }
}

/// The preparation that is common in robot identification: angle, two central differences, friction's sign from the velocity; then torque
/// and all columns decimated.
pub(crate) fn central_differences(uniform: &Uniform) -> Prepared<'static> {
    let rate_hz = uniform.rate_hz;
    let edge_hz = BUTTERWORTH.1.min(HIGHEST * rate_hz);
    let angle = low_pass(BUTTERWORTH.0, edge_hz, rate_hz, &uniform.angle_rad);
    let velocity = differences(&angle, rate_hz);
    let acceleration = differences(&velocity, rate_hz);
    let step = ((EDGE_SHARE * 0.5 * rate_hz / CHEBYSHEV.2).round() as usize).max(1);
    let cut = ((CUT_S * rate_hz).round() as usize).min(velocity.len() / 4);
    let kept = cut..velocity.len() - cut;
    let mask = uniform.present.iter().enumerate();
    let mask = mask.map(|(index, present)| f64::from(*present && kept.contains(&index))).collect();
    let columns = [uniform.time_s.clone(), angle, velocity, acceleration];
    let motion = KnobMotion { exact: false, ..KnobMotion::as_given(columns, edge_hz) };
    let band = Band::fixed(CHEBYSHEV.2.min(HIGHEST * rate_hz), uniform.torque_noise_mnm());
    let fir = if step == 1 { Fir::identity() } else { before_decimation(band.edge_hz, rate_hz) };
    let row_filter = RowFilter { rate_hz, mask, fir, step, threshold_rad_s: 0.0, response: None };
    Prepared { motion, torque_mnm: uniform.torque_mnm.clone().into(), row_filter, band }
}

/// Plain central differences, per second; the ends repeat their neighbours.
fn differences(signal: &[f64], rate_hz: f64) -> Vec<f64> {
    let last = signal.len().saturating_sub(1);
    let around = |at: usize| at.min(last.saturating_sub(1)).max(1);
    let rate = |at: usize| 0.5 * rate_hz * (signal[(around(at) + 1).min(last)] - signal[around(at) - 1]);
    (0..signal.len()).map(rate).collect()
}

/// The impulse response of the low-pass run both ways, as a filter of finite length.
fn before_decimation(edge_hz: f64, rate_hz: f64) -> Fir {
    let Some(sections) = chebyshev1_low_pass(CHEBYSHEV.0, CHEBYSHEV.1, edge_hz, rate_hz) else {
        return Fir::identity();
    };
    let half_length = (RINGING_PERIODS * rate_hz / edge_hz).ceil() as usize;
    let mut impulse = vec![0.0; 4 * half_length + 1];
    impulse[2 * half_length] = 1.0;
    let response = sections.filter_zero_phase(&impulse);
    Fir::of_taps(&response[half_length..=3 * half_length])
}
