//! Friction whose contacts bend before they slip.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};
use crate::plant::Bristle;

/// `presliding-hysteresis`.
pub(super) static KIND: Kind = Kind {
    name: "presliding-hysteresis",
    in_catalogue: true,
    wish: |size_mnm| Wish { least_coulomb_mnm: 5.0 * size_mnm, ..Wish::default() },
    draw: |_, draw| Box::new(PreslidingHysteresis { damping_ratio: draw.uniform(0.02, 0.1) }),
};

struct PreslidingHysteresis {
    damping_ratio: f64,
}

impl Acts for PreslidingHysteresis {
    fn size_limits(&self) -> [f64; 2] {
        [3e-4, 0.12]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"bristle_rad": size})
    }

    fn bristle(&self, size: f64) -> Option<Bristle> {
        Some(Bristle { length_rad: size, damping_ratio: self.damping_ratio, deflection: 0.0 })
    }
}
