//! Friction that settles with time, as grease warms.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `friction-drift`.
pub(super) static KIND: Kind = Kind {
    name: "friction-drift",
    in_catalogue: true,
    wish: |size_mnm| Wish { least_coulomb_mnm: 5.0 * size_mnm, ..Wish::default() },
    draw: |_, draw| Box::new(FrictionDrift { time_constant_s: draw.uniform(0.8, 3.0) }),
};

struct FrictionDrift {
    time_constant_s: f64,
}

impl Acts for FrictionDrift {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 2.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"start_excess": size, "time_constant_s": self.time_constant_s})
    }

    fn friction_factor(&self, size: f64, state: &State, _: bool) -> f64 {
        1.0 + size * (-state.time_s / self.time_constant_s).exp()
    }
}
