//! Detents of another shape than a sine.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `detent-harmonics`.
pub(super) static KIND: Kind = Kind {
    name: "detent-harmonics",
    in_catalogue: true,
    wish: |size_mnm| Wish { detents: Some(true), least_detent_mnm: 6.0 * size_mnm, ..Wish::default() },
    draw: |_, draw| {
        Box::new(match draw.below(3) {
            0 => DetentHarmonics::Triangle,
            1 => DetentHarmonics::Sawtooth(draw.uniform(0.1, 0.3)),
            _ => DetentHarmonics::Harmonics(draw.phase(), draw.phase(), draw.uniform(0.2, 0.8)),
        })
    },
};

/// The shape of one detent period: which, and its numbers.
enum DetentHarmonics {
    /// A sine mixed with a triangle by the effect's share.
    Triangle,
    /// A sine mixed with a sawtooth that rises over this fraction of the period.
    Sawtooth(f64),
    /// Second and third harmonic: their phases, and the third's part of the second's size.
    Harmonics(f64, f64, f64),
}

impl Acts for DetentHarmonics {
    fn size_limits(&self) -> [f64; 2] {
        [1e-4, 0.9]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        match self {
            Self::Triangle => json!({"shape": "triangle", "share": size}),
            Self::Sawtooth(rising) => json!({"shape": "sawtooth", "share": size, "rising_fraction": rising}),
            Self::Harmonics(second, third, ratio) => json!({"shape": "harmonics", "second": size,
                "second_phase_rad": second, "third": size * ratio, "third_phase_rad": third}),
        }
    }

    fn detent_wave(&self, size: f64, x: f64, _: f64) -> Option<f64> {
        Some(match self {
            Self::Harmonics(second, third, ratio) => {
                x.sin() + size * ((2.0 * x + second).sin() + ratio * (3.0 * x + third).sin())
            }
            Self::Triangle => (1.0 - size) * x.sin() + size * tooth(x, 0.5),
            Self::Sawtooth(rising) => (1.0 - size) * x.sin() + size * tooth(x, *rising),
        })
    }
}

/// A wave from −1 up to 1 and back, its zero at 0 on the rise, that rises over a fraction of its period.
fn tooth(x: f64, rising: f64) -> f64 {
    let turn = (x / TAU + 0.5 * rising).rem_euclid(1.0);
    if turn < rising { 2.0 * turn / rising - 1.0 } else { 1.0 - 2.0 * (turn - rising) / (1.0 - rising) }
}
