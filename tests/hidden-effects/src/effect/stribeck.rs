//! Friction that rises towards zero speed.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `stribeck`.
pub(super) static KIND: Kind = Kind {
    name: "stribeck",
    in_catalogue: true,
    wish: |size_mnm| Wish { least_coulomb_mnm: size_mnm, ..Wish::default() },
    draw: |_, draw| {
        Box::new(Stribeck {
            speed_rad_s: draw.log_uniform(0.4, 2.5),
            exponent: if draw.chance(0.5) { 1.0 } else { 2.0 },
        })
    },
};

struct Stribeck {
    speed_rad_s: f64,
    exponent: f64,
}

impl Acts for Stribeck {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 150.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"extra_mnm": size, "speed_rad_s": self.speed_rad_s, "exponent": self.exponent})
    }

    fn friction_extra(&self, size: f64, state: &State) -> f64 {
        size * (-(state.velocity_rad_s.abs() / self.speed_rad_s).powf(self.exponent)).exp()
    }
}
