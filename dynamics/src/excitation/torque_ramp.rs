//! Ramps that rise until the knob breaks away.

use serde::{Deserialize, Serialize};

use super::Jet;

/// Teeth of alternating sign, each pair a little higher than the one before, then again from the lowest.
///
/// A knob that holds more than it needs to slide runs away under a torque that has torn it loose.
/// Here it breaks away near the peak of the first tooth that is high enough, and that tooth is over
/// soon; the next one brings it back.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorqueRamp {
    /// Number of heights; they are equal steps up to the full amplitude.
    pub levels: u32,
    /// Duration of one tooth, up and down, s.
    pub tooth_s: f64,
}

impl Default for TorqueRamp {
    /// 16 heights of 0.3 s each way: 9.6 s in all.
    fn default() -> Self {
        Self { levels: 16, tooth_s: 0.3 }
    }
}

impl TorqueRamp {
    pub(super) fn at(&self, time_s: f64) -> Jet {
        let Self { levels, tooth_s } = *self;
        let tooth = (time_s / tooth_s).floor();
        let within_s = time_s - tooth * tooth_s;
        let pair = (tooth / 2.0).floor();
        let sign = if tooth - 2.0 * pair < 0.5 { 1.0 } else { -1.0 };
        let level = (pair.rem_euclid(f64::from(levels)) + 1.0) / f64::from(levels);
        let half_s = tooth_s / 2.0;
        let rise = if within_s <= half_s {
            Jet::smooth_step(within_s, half_s)
        } else {
            let mirrored = Jet::smooth_step(tooth_s - within_s, half_s);
            Jet { first: -mirrored.first, ..mirrored }
        };
        rise.scaled(sign * level)
    }
}
