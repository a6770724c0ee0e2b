//! The amounts that the sensors' noise adds to sums over rows, so that they can be subtracted.
//!
//! Least squares holds its columns for exact, but an acceleration that was differentiated twice is not: its noise adds
//! to its square and draws the inertia towards zero. And a torque by which the angle was corrected for the torque
//! sensor's twist brings the same noise into both sides, which draws the inertia up. Both sums are known, since both
//! noises are white where they enter and every filter after that is known, so they are taken off the normal
//! equations (W. A. Fuller, Measurement Error Models, Wiley 1987, section 2.2).

use std::f64::consts::TAU;

use super::band::Band;
use super::motion::{KnobMotion, integrals};
use super::row_filter::RowFilter;

/// Beyond this multiple of the band's edge the rows' filter passes nothing.
const BEYOND: f64 = 1.6;

/// Sums over all rows that noise alone gives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SensorNoise {
    /// Of the squared velocity, rad²/s².
    pub(crate) velocity_squares: f64,
    /// Of the squared acceleration, rad²/s⁴.
    pub(crate) acceleration_squares: f64,
    /// Of acceleration times torque, mNm·rad/s².
    pub(crate) acceleration_torque: f64,
}

impl SensorNoise {
    /// What the noise of encoder, torque channel and accelerometer adds in this row filter.
    pub(crate) fn of(row_filter: &RowFilter, motion: &KnobMotion, band: &Band) -> Self {
        if motion.exact || motion.angle_density == 0.0 {
            return Self::default();
        }
        let smoother = motion.smoother(row_filter.rate_hz);
        let torque_density = band.torque_noise_mnm.powi(2) / (0.5 * row_filter.rate_hz);
        let compliance = motion.compliance_rad_mnm;
        let edge_hz = (BEYOND * band.edge_hz).min(0.5 * row_filter.rate_hz);
        let angle_density = motion.angle_density + torque_density * compliance * compliance;
        let weight = row_filter.weight();
        let [velocity_squares, acceleration_squares, acceleration_torque] = integrals(edge_hz, |frequency_hz| {
            let gain =
                row_filter.fir.gain(frequency_hz, row_filter.rate_hz) * smoother.gain(frequency_hz, row_filter.rate_hz);
            let passed = weight * gain.powi(2);
            let velocity = passed * (TAU * frequency_hz).powi(2) * motion.encoder_share(frequency_hz);
            let acceleration = passed * motion.acceleration_density(frequency_hz, angle_density);
            [angle_density * velocity, acceleration, torque_density * compliance * velocity]
        });
        Self { velocity_squares, acceleration_squares, acceleration_torque }
    }
}
