//! Coulomb friction that is larger over some 20° of the travel.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `scratch`.
pub(super) static KIND: Kind = Kind {
    name: "scratch",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |scene, draw| {
        let [lowest, highest] = scene.travel_rad;
        Box::new(Scratch {
            centre_rad: scene.middle_rad() + draw.uniform(-0.25, 0.25) * (highest - lowest),
            width_rad: draw.uniform(12.0, 30.0_f64).to_radians(),
        })
    },
};

struct Scratch {
    centre_rad: f64,
    width_rad: f64,
}

impl Acts for Scratch {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 150.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"extra_mnm": size, "begin_rad": self.centre_rad - 0.5 * self.width_rad,
            "end_rad": self.centre_rad + 0.5 * self.width_rad})
    }

    fn friction_extra(&self, size: f64, state: &State) -> f64 {
        size * f64::from((state.angle_rad - self.centre_rad).abs() < 0.5 * self.width_rad)
    }
}
