//! Detents that are stronger in one direction.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `directional-detents`.
pub(super) static KIND: Kind = Kind {
    name: "directional-detents",
    in_catalogue: false,
    wish: |size_mnm| Wish { detents: Some(true), least_detent_mnm: 6.0 * size_mnm, ..Wish::default() },
    draw: |_, _| Box::new(DirectionalDetents),
};

struct DirectionalDetents;

impl Acts for DirectionalDetents {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 0.9]
    }

    fn parameters(&self, size: f64, knob: &Knob) -> Value {
        json!({"depth": size, "amplitude_mnm": knob.detent_amplitude})
    }

    fn detent_wave(&self, size: f64, x: f64, velocity_rad_s: f64) -> Option<f64> {
        Some((1.0 + size * (velocity_rad_s / 0.2).tanh()) * x.sin())
    }
}
