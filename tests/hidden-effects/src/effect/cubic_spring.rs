//! A spring that stiffens.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `cubic-spring`.
pub(super) static KIND: Kind = Kind {
    name: "cubic-spring",
    in_catalogue: false,
    // The base model would take it for detents if the knob had none of its own.
    wish: |_| Wish { detents: Some(true), ..Wish::default() },
    draw: |scene, _| Box::new(CubicSpring { centre_rad: scene.middle_rad() }),
};

struct CubicSpring {
    centre_rad: f64,
}

impl Acts for CubicSpring {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 40.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"stiffness_mnm_rad3": size, "centre_rad": self.centre_rad})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        size * (state.angle_rad - self.centre_rad).powi(3)
    }
}
