//! Inertia that varies twice in a turn, as behind a universal joint.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `angle-dependent-inertia`.
pub(super) static KIND: Kind = Kind {
    name: "angle-dependent-inertia",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |_, draw| Box::new(VaryingInertia { phase_rad: draw.phase() }),
};

struct VaryingInertia {
    phase_rad: f64,
}

impl Acts for VaryingInertia {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 0.7]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"depth": size, "phase_rad": self.phase_rad})
    }

    fn inertia_wave(&self, size: f64) -> Option<[f64; 2]> {
        Some([size, self.phase_rad])
    }
}
