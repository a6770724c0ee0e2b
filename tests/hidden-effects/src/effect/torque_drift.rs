//! A torque sensor whose zero drifts.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `torque-drift`.
pub(super) static KIND: Kind = Kind {
    name: "torque-drift",
    in_catalogue: false,
    wish: |_| Wish::default(),
    draw: |scene, _| Box::new(TorqueDrift { sign: scene.sign }),
};

struct TorqueDrift {
    sign: f64,
}

impl Acts for TorqueDrift {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 20.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"rate_mnm_s": self.sign * size})
    }

    fn reading(&self, size: f64, torque_mnm: f64, time_s: f64) -> f64 {
        torque_mnm + self.sign * size * time_s
    }
}
