//! A mass off the axis, in gravity.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `mass-imbalance`.
pub(super) static KIND: Kind = Kind {
    name: "mass-imbalance",
    in_catalogue: true,
    // The base model would take it for detents if the knob had none of its own.
    wish: |_| Wish { detents: Some(true), ..Wish::default() },
    draw: |_, draw| Box::new(MassImbalance { phase_rad: draw.phase() }),
};

struct MassImbalance {
    phase_rad: f64,
}

impl Acts for MassImbalance {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 40.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"amplitude_mnm": size, "phase_rad": self.phase_rad})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        size * (state.angle_rad + self.phase_rad).sin()
    }
}
