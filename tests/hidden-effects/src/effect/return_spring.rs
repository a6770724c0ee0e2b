//! A spring that pulls to a centre.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `return-spring`.
pub(super) static KIND: Kind = Kind {
    name: "return-spring",
    in_catalogue: true,
    // The base model would take it for detents if the knob had none of its own.
    wish: |_| Wish { detents: Some(true), ..Wish::default() },
    draw: |scene, _| Box::new(ReturnSpring { centre_rad: scene.centre_rad }),
};

struct ReturnSpring {
    centre_rad: f64,
}

impl Acts for ReturnSpring {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 40.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"stiffness_mnm_rad": size, "centre_rad": self.centre_rad})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        size * (state.angle_rad - self.centre_rad)
    }
}
