//! The band in which torque and motion are compared.

use std::f64::consts::TAU;

use dynamics::Calibration;

use super::row_filter::ROWS_PER_EDGE;
use super::spectrum::{AngleSpectrum, Spectrum, white_density};
use super::uniform::Uniform;

/// Share of the torque's power above its noise that may lie beyond the fit's band.
const POWER_BEYOND_BAND: f64 = 1e-4;
/// Widest band, as a share of the sample rate.
const WIDEST: f64 = 0.1;
/// The band reaches at least to this multiple of the sweep's highest frequency …
const NARROWEST_PER_SWEEP: f64 = 17.0;
/// … and at most to this one, unless fine detents need more: beyond, rigs ring and their sensors differ.
const WIDEST_PER_SWEEP: f64 = 43.0;
/// Widest band as a multiple of 1/delay of a calibrated torque channel: a low-pass is a mere delay only far below its bandwidth.
/// For a second-order Butterworth the limit is an eighth of the bandwidth, where the difference from a delay is half a microsecond.
const WIDEST_PER_LAG: f64 = 0.028;
/// Rows that the band should give if the sample rate permits: fewer make poor intervals.
const FEWEST_ROWS: f64 = 200.0;

/// The band in which torque and motion are compared.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Band {
    /// Upper edge, Hz.
    pub(crate) edge_hz: f64,
    /// Torque noise, if it is white as the upper end of its spectrum says, mNm.
    pub(crate) torque_noise_mnm: f64,
    /// Edge of the widest band in which the acceleration is signal, Hz.
    pub(crate) clear_hz: f64,
    /// Density of the encoder's noise in the band, rad²/Hz.
    pub(crate) angle_density: f64,
}

impl Band {
    /// A band whose edge does not depend on the angle's noise, of which nothing is known.
    pub(crate) fn fixed(edge_hz: f64, torque_noise_mnm: f64) -> Self {
        Self { edge_hz, torque_noise_mnm, clear_hz: f64::INFINITY, angle_density: 0.0 }
    }

    /// The band as far as the torque exceeds its noise: beyond, there is only noise, and that
    /// of a twice differentiated angle grows fast. An exact motion has none and takes the widest band.
    pub(crate) fn of(uniform: &Uniform, exact: bool, calibration: Option<&Calibration>) -> Self {
        let rate_hz = uniform.rate_hz;
        let floor = uniform.torque_density;
        let torque_noise_mnm = uniform.torque_noise_mnm();
        let widest_hz = WIDEST * rate_hz;
        if exact {
            return Self::fixed(widest_hz, torque_noise_mnm);
        }
        let torque = Spectrum::welch(&uniform.torque_mnm, rate_hz);
        let reach_hz = torque.power_below(1.0 - POWER_BEYOND_BAND, 2.0 * floor);
        let AngleSpectrum { sweep_hz, clear_hz, noise_density: angle_density } =
            AngleSpectrum::of(&uniform.angle_rad, rate_hz);
        // An accelerometer sees motion that the encoder does not, above all contact, whose spectrum looks like noise.
        let (clear_hz, angle_density) = match uniform.acceleration_rad_s2 {
            Some(_) => (f64::INFINITY, white_density(&uniform.angle_rad, rate_hz)),
            None => (clear_hz, angle_density),
        };
        let duration_s = uniform.torque_mnm.len() as f64 / rate_hz;
        let enough_hz = FEWEST_ROWS / (ROWS_PER_EDGE * duration_s);
        let lowest_hz = (NARROWEST_PER_SWEEP * sweep_hz).max(enough_hz);
        let lag_s = calibration.map_or(0.0, |known| known.torque_delay_s.abs());
        let alike_hz = (WIDEST_PER_LAG / lag_s).max(enough_hz);
        let wanted_hz = (1.25 * reach_hz).min(WIDEST_PER_SWEEP * sweep_hz).max(lowest_hz);
        let edge_hz = wanted_hz.min(alike_hz).min(clear_hz).min(widest_hz);
        Self { edge_hz, torque_noise_mnm, clear_hz, angle_density }
    }

    /// The band as far as the encoder alone shows the acceleration.
    pub(crate) fn of_encoder(&self, uniform: &Uniform) -> Self {
        let AngleSpectrum { clear_hz, noise_density: angle_density, .. } =
            AngleSpectrum::of(&uniform.angle_rad, uniform.rate_hz);
        Self { edge_hz: self.edge_hz.min(clear_hz), clear_hz, angle_density, ..*self }
    }

    /// The band widened for detents of a wavenumber (1/rad) that the knob crosses at a speed; `None` if it need not be.
    pub(crate) fn widened(&self, wavenumber: f64, speed_rad_s: f64, rate_hz: f64) -> Option<Self> {
        let needed_hz = (1.2 * wavenumber * speed_rad_s / TAU).min(WIDEST * rate_hz);
        (needed_hz > 1.2 * self.edge_hz).then_some(Self { edge_hz: needed_hz, ..*self })
    }
}
