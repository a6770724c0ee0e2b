//! The part of the hand's torque that the motor carries.

use biquad::Coefficients;

/// The slow part of a torque: (2·ζ·x + 1)/(x² + 2·ζ·x + 1) with x = s/(2π·edge), by the bilinear transform.
///
/// The part that it leaves out begins with the second power of the frequency, so that slow torques pass without delay: any delay,
/// however small, would be felt as negative damping that grows with inertia.
pub(crate) fn slow_part(edge_hz: f64, damping_ratio: f64, rate_hz: f64) -> Option<Coefficients<f64>> {
    if !(edge_hz > 0.0 && edge_hz < 0.5 * rate_hz) {
        return None;
    }
    let k = (std::f64::consts::PI * edge_hz / rate_hz).tan();
    let (damped, square) = (2.0 * damping_ratio * k, k * k);
    let scale = (1.0 + damped + square).recip();
    Some(Coefficients {
        b0: scale * (damped + square),
        b1: scale * 2.0 * square,
        b2: scale * (square - damped),
        a1: scale * (2.0 * square - 2.0),
        a2: scale * (1.0 - damped + square),
    })
}

/// Share of the newest value that a low-pass of first order takes in at each tick; none for an edge of zero.
pub(crate) fn taken_in(edge_hz: f64, step_s: f64) -> f64 {
    -(-std::f64::consts::TAU * edge_hz * step_s).exp_m1()
}
