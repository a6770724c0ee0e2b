//! Coulomb friction that jumps at an angle.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `friction-step`.
pub(super) static KIND: Kind = Kind {
    name: "friction-step",
    in_catalogue: false,
    wish: |size_mnm| Wish { least_coulomb_mnm: 5.0 * size_mnm, ..Wish::default() },
    draw: |scene, draw| {
        let [lowest, highest] = scene.travel_rad;
        Box::new(FrictionStep { angle_rad: scene.middle_rad() + draw.uniform(-0.25, 0.25) * (highest - lowest) })
    },
};

struct FrictionStep {
    angle_rad: f64,
}

impl Acts for FrictionStep {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 2.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"excess": size, "angle_rad": self.angle_rad})
    }

    fn friction_factor(&self, size: f64, state: &State, viscous: bool) -> f64 {
        if viscous { 1.0 } else { 1.0 + size * f64::from(state.angle_rad > self.angle_rad) }
    }
}
