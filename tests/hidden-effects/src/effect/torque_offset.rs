//! A zero of the torque sensor that nobody took off.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `torque-offset`.
pub(super) static KIND: Kind = Kind {
    name: "torque-offset",
    in_catalogue: true,
    wish: |size_mnm| Wish {
        detents: Some(true),
        // An offset below the Coulomb friction is only an asymmetry of friction.
        most_coulomb_mnm: (2.0 * size_mnm).clamp(0.7, 3.0),
        ..Wish::default()
    },
    draw: |scene, _| Box::new(TorqueOffset { sign: scene.sign }),
};

struct TorqueOffset {
    sign: f64,
}

impl Acts for TorqueOffset {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 40.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"offset_mnm": self.sign * size})
    }

    fn reading(&self, size: f64, torque_mnm: f64, _: f64) -> f64 {
        torque_mnm + self.sign * size
    }
}
