//! Drag of a fluid that is thrown about.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `quadratic-drag`.
pub(super) static KIND: Kind = Kind {
    name: "quadratic-drag",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |_, _| Box::new(QuadraticDrag),
};

struct QuadraticDrag;

impl Acts for QuadraticDrag {
    fn size_limits(&self) -> [f64; 2] {
        [1e-4, 1.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"coefficient_mnm_s2_rad2": size})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        size * state.velocity_rad_s * state.velocity_rad_s.abs()
    }
}
