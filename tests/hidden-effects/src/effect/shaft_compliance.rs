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
        let damping_ratio = draw.uniform(0.03, 0.12);
        // Every other shaft has a cap with inertia.
        let outer_share = draw.uniform(-0.7, 0.7).max(0.0);
        Box::new(ShaftCompliance {
            damping_ratio,
            outer_share,
            inner_inertia: (1.0 - outer_share) * scene.knob.inertia,
        })
    },
};

struct ShaftCompliance {
    damping_ratio: f64,
    outer_share: f64,
    inner_inertia: f64,
}

impl ShaftCompliance {
    /// Stiffness and damping of a shaft on which the inner body resonates at `size` Hz, mNm/rad and mNm s/rad.
    fn shaft(&self, size: f64) -> (f64, f64) {
        let speed = TAU * size;
        (self.inner_inertia * speed * speed, 2.0 * self.damping_ratio * self.inner_inertia * speed)
    }
}

impl Acts for ShaftCompliance {
    fn size_limits(&self) -> [f64; 2] {
        [500.0, 15.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        let (stiffness, damping) = self.shaft(size);
        json!({
            "resonance_hz": size, "stiffness_mnm_rad": stiffness, "damping_mnm_s_rad": damping,
            "outer_share_of_inertia": self.outer_share,
        })
    }

    fn link(&self, size: f64) -> Link {
        let (stiffness, damping) = self.shaft(size);
        Link::Spring { outer_share: self.outer_share, stiffness, damping }
    }
}
