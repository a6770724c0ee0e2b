//! Many sines at once.

use std::f64::consts::{PI, SQRT_2, TAU};

use serde::{Deserialize, Serialize};

use super::Jet;

/// Time over which the multisine is faded in, s: it does not start at zero by itself.
const FADE_IN_S: f64 = 0.5;

/// Sines at the odd multiples of a base frequency, equal in speed, with Schroeder's phases.
///
/// Odd multiples only, so that even distortion shows between them. Phases after M. R. Schroeder,
/// Synthesis of low-peak-factor signals, IEEE Trans. Inf. Theory 16 (1970) 85–89.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Multisine {
    /// Base frequency, Hz; the sum repeats after its inverse.
    pub base_hz: f64,
    /// Number of sines; the highest is (2·tones − 1) · base.
    pub tones: u32,
}

impl Default for Multisine {
    /// 0.2 Hz to 6.2 Hz in 16 sines.
    fn default() -> Self {
        Self { base_hz: 0.2, tones: 16 }
    }
}

impl Multisine {
    /// 2 Hz to 62 Hz in 16 sines: where delays of a fraction of a sample show.
    #[must_use]
    pub fn fast() -> Self {
        Self { base_hz: 2.0, tones: 16 }
    }

    /// One sine at 30 Hz, where the paper states its rig's lag.
    #[must_use]
    pub fn tone() -> Self {
        Self { base_hz: 30.0, tones: 1 }
    }

    pub(super) fn at(&self, time_s: f64) -> Jet {
        let tones = f64::from(self.tones);
        let mut sum = Jet::constant(0.0);
        let mut amplitudes = 0.0;
        for index in 0..self.tones {
            let multiple = f64::from(2 * index + 1);
            let omega = TAU * self.base_hz * multiple;
            let phase = -PI * f64::from(index) * f64::from(index) / tones;
            let amplitude = 1.0 / multiple;
            amplitudes += amplitude * amplitude;
            sum = sum + Jet { value: omega * time_s + phase, first: omega, second: 0.0 }.sin().scaled(amplitude);
        }
        // Schroeder's phases keep the peak of many sines near 1.7 times the RMS of the sum.
        let crest = if self.tones == 1 { SQRT_2 } else { 1.7 };
        let peak = crest * (amplitudes / 2.0).sqrt();
        sum.scaled(1.0 / peak) * Jet::smooth_step(time_s, FADE_IN_S)
    }
}
