//! Lost motion between cap and inner body.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};
use crate::plant::Link;

/// `backlash`.
pub(super) static KIND: Kind = Kind {
    name: "backlash",
    in_catalogue: true,
    wish: |size_mnm| Wish { least_coulomb_mnm: 3.0 * size_mnm, ..Wish::default() },
    draw: |scene, draw| {
        let inner_share = draw.uniform(0.1, 0.7);
        let stiffness_mnm_rad = draw.log_uniform(4e3, 2e4);
        let critical = 2.0 * (stiffness_mnm_rad * inner_share * scene.knob.inertia).sqrt();
        Box::new(Backlash { inner_share, stiffness_mnm_rad, damping_mnm_s_rad: draw.uniform(0.2, 0.5) * critical })
    },
};

struct Backlash {
    inner_share: f64,
    stiffness_mnm_rad: f64,
    damping_mnm_s_rad: f64,
}

impl Acts for Backlash {
    fn size_limits(&self) -> [f64; 2] {
        [3e-5, 0.03]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({
            "half_gap_rad": size, "inner_share_of_inertia": self.inner_share,
            "contact_stiffness_mnm_rad": self.stiffness_mnm_rad, "contact_damping_mnm_s_rad": self.damping_mnm_s_rad})
    }

    fn link(&self, size: f64) -> Link {
        Link::Gap {
            half_gap: size,
            inner_share: self.inner_share,
            stiffness: self.stiffness_mnm_rad,
            damping: self.damping_mnm_s_rad,
        }
    }
}
