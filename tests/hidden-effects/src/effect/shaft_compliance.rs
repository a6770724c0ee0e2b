//! A soft shaft between cap and inner body.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};
use crate::plant::Link;

/// `shaft-compliance`.
pub(super) static KIND: Kind = Kind {
    name: "shaft-compliance",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |scene, draw| {
        Box::new(ShaftCompliance { damping_ratio: draw.uniform(0.03, 0.12), inertia: scene.knob.inertia })
    },
};

struct ShaftCompliance {
    damping_ratio: f64,
    inertia: f64,
}

impl ShaftCompliance {
    /// Stiffness and damping of a shaft that resonates at `size` Hz, mNm/rad and mNm s/rad.
    fn shaft(&self, size: f64) -> (f64, f64) {
        let speed = TAU * size;
        (self.inertia * speed * speed, 2.0 * self.damping_ratio * self.inertia * speed)
    }
}

impl Acts for ShaftCompliance {
    fn size_limits(&self) -> [f64; 2] {
        [500.0, 15.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        let (stiffness, damping) = self.shaft(size);
        json!({"resonance_hz": size, "stiffness_mnm_rad": stiffness, "damping_mnm_s_rad": damping})
    }

    fn link(&self, size: f64) -> Link {
        let (stiffness, damping) = self.shaft(size);
        Link::Spring { stiffness, damping }
    }
}
