//! The twist of the torque sensor, the angle by which the knob lags behind the encoder.

use dynamics::Calibration;

/// Compliance of the torque sensor, rad/mNm: zero where it is stiff or nothing is known of it, below zero as the hand sees it on a
/// rig that renders.
pub(crate) fn compliance_rad_mnm(known: Option<&Calibration>) -> f64 {
    stiffness_mnm_rad(known).recip()
}

/// The knob's angle from the encoder's, rad.
pub(crate) fn knob_angle_rad(angle_rad: &[f64], torque_mnm: &[f64], known: Option<&Calibration>) -> Vec<f64> {
    let stiffness_mnm_rad = stiffness_mnm_rad(known);
    angle_rad.iter().zip(torque_mnm).map(|(angle, torque)| angle - torque / stiffness_mnm_rad).collect()
}

/// Stiffness of the torque sensor; infinite where a calibration has none.
fn stiffness_mnm_rad(known: Option<&Calibration>) -> f64 {
    let stiffness_mnm_rad = known.map(|known| known.torque_sensor_stiffness_mnm_rad);
    stiffness_mnm_rad.filter(|stiffness| *stiffness != 0.0 && !stiffness.is_nan()).unwrap_or(f64::INFINITY)
}
