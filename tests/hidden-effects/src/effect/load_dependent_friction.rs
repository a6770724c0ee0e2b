//! Friction that grows with the load.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `load-dependent-friction`.
pub(super) static KIND: Kind = Kind {
    name: "load-dependent-friction",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |_, _| Box::new(LoadFriction),
};

struct LoadFriction;

impl Acts for LoadFriction {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 0.6]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"coefficient": size})
    }

    fn load_friction(&self, size: f64) -> f64 {
        size
    }
}
