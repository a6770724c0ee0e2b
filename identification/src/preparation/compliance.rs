//! The twist of the torque sensor, by which the knob is behind the encoder.

use dynamics::Calibration;

/// Compliance of the torque sensor, rad/mNm: zero where it is stiff or nothing is known of it, below zero as the hand sees it on a
/// rig that renders.
pub(crate) fn compliance_rad_mnm(known: Option<&Calibration>) -> f64 {
    let compliance = known.map(|known| 1.0 / known.torque_sensor_stiffness_mnm_rad);
    compliance.filter(|compliance| compliance.is_finite()).unwrap_or(0.0)
}

/// The knob's angle from the encoder's, rad.
pub(crate) fn knob_angle_rad(angle_rad: &[f64], torque_mnm: &[f64], known: Option<&Calibration>) -> Vec<f64> {
    let compliance_rad_mnm = compliance_rad_mnm(known);
    angle_rad.iter().zip(torque_mnm).map(|(angle, torque)| angle - compliance_rad_mnm * torque).collect()
}
