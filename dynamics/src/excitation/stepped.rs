//! Sweeps whose amplitude rises step by step.

use serde::{Deserialize, Serialize};

use super::Jet;

/// Sweeps up to `top_hz` and back, one for each level of amplitude, then again from the lowest.
///
/// Small amplitudes keep a knob within one detent or its presliding, large ones cross many: the
/// same frequencies at several amplitudes separate the effects of frequency from those of amplitude.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SteppedAmplitude {
    /// Number of levels; the amplitudes are equal steps up to the full one.
    pub levels: u32,
    /// Duration of one level, s.
    pub level_s: f64,
    /// Highest frequency, Hz, rounded so that every level ends where it began.
    pub top_hz: f64,
}

impl Default for SteppedAmplitude {
    /// Five levels of 2 s up to 3 Hz.
    fn default() -> Self {
        Self { levels: 5, level_s: 2.0, top_hz: 3.0 }
    }
}

impl SteppedAmplitude {
    pub(super) fn at(&self, time_s: f64) -> Jet {
        let Self { levels, level_s, top_hz } = *self;
        let step = (time_s / level_s).floor();
        let within_s = time_s - step * level_s;
        let level = (step.rem_euclid(f64::from(levels)) + 1.0) / f64::from(levels);
        // A level that holds a whole number of turns of the phase starts and ends at zero angle and
        // zero frequency, so that the amplitude can change there without a jolt.
        let turns = (top_hz * level_s / 2.0).round().max(1.0);
        let half_s = level_s / 2.0;
        let slope = std::f64::consts::TAU * turns / (half_s * half_s);
        let phase = if within_s <= half_s {
            Jet { value: slope * within_s * within_s / 2.0, first: slope * within_s, second: slope }
        } else {
            let left_s = level_s - within_s;
            Jet { value: slope * (half_s * half_s - left_s * left_s / 2.0), first: slope * left_s, second: -slope }
        };
        phase.sin().scaled(level)
    }
}
