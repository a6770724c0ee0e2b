//! The preparation that is common in robot identification, for comparison with published figures.

use super::filter::{Fir, butterworth_low_pass, chebyshev1_low_pass};
use super::fixed_preparation::FixedPreparation;
use super::motion::{Band, KnobMotion};
use super::row_filter::RowFilter;
use super::uniform::Uniform;

/// Order and edge of the Butterworth low-pass on the angle, run both ways, Hz.
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
/// Highest edge as a share of the sample rate.
const HIGHEST: f64 = 0.45;

/// Angle, two central differences, friction's sign from the velocity; then torque and all columns decimated.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "numbers of samples")]
pub(crate) fn central_differences(uniform: &Uniform) -> FixedPreparation {
    let rate_hz = uniform.rate_hz;
    let edge_hz = BUTTERWORTH.1.min(HIGHEST * rate_hz);
    let angle = butterworth_low_pass(BUTTERWORTH.0, edge_hz, rate_hz)
        .map_or_else(|_| uniform.angle_rad.clone(), |sections| sections.filter_zero_phase(&uniform.angle_rad));
    let velocity = differences(&angle, rate_hz);
    let acceleration = differences(&velocity, rate_hz);
    let step = ((EDGE_SHARE * 0.5 * rate_hz / CHEBYSHEV.2).round() as usize).max(1);
    let cut = ((CUT_S * rate_hz).round() as usize).min(velocity.len() / 4);
    let kept = cut..velocity.len() - cut;
    let mask = uniform.present.iter().enumerate();
    let mask = mask.map(|(index, present)| f64::from(*present && kept.contains(&index))).collect();
    let columns = [uniform.time_s.clone(), angle, velocity, acceleration];
    let motion = KnobMotion { exact: false, ..KnobMotion::as_given(columns, edge_hz) };
    let torque_noise_mnm = (uniform.torque_density * 0.5 * rate_hz).sqrt();
    let band = Band::fixed(CHEBYSHEV.2.min(HIGHEST * rate_hz), torque_noise_mnm);
    let fir = if step == 1 { Fir::identity() } else { before_decimation(band.edge_hz, rate_hz) };
    let row_filter = RowFilter { rate_hz, mask, fir, step, threshold_rad_s: 0.0, response: None };
    FixedPreparation { motion, torque_mnm: uniform.torque_mnm.clone(), row_filter, band }
}

/// Plain central differences, per second; the ends repeat their neighbours.
fn differences(signal: &[f64], rate_hz: f64) -> Vec<f64> {
    let inner = signal.windows(3).map(|window| 0.5 * rate_hz * (window[2] - window[0]));
    let mut rate: Vec<f64> = std::iter::once(0.0).chain(inner).chain([0.0]).collect();
    rate.resize(signal.len(), 0.0);
    if let [first, second, .., last_but_one, last] = rate.as_mut_slice() {
        (*first, *last) = (*second, *last_but_one);
    }
    rate
}

/// The impulse response of the low-pass run both ways, as a filter of finite length.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a length in samples")]
fn before_decimation(edge_hz: f64, rate_hz: f64) -> Fir {
    let Ok(sections) = chebyshev1_low_pass(CHEBYSHEV.0, CHEBYSHEV.1, edge_hz, rate_hz) else {
        return Fir::identity();
    };
    let half_length = (RINGING_PERIODS * rate_hz / edge_hz).ceil() as usize;
    let mut impulse = vec![0.0; 4 * half_length + 1];
    impulse[2 * half_length] = 1.0;
    let response = sections.filter_zero_phase(&impulse);
    Fir::of_taps(&response[half_length..=3 * half_length])
}
