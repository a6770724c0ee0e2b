//! Coulomb friction that lets go now and then.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `friction-dropouts`.
pub(super) static KIND: Kind = Kind {
    name: "friction-dropouts",
    in_catalogue: false,
    wish: |size_mnm| Wish { least_coulomb_mnm: 5.0 * size_mnm, ..Wish::default() },
    draw: |scene, draw| {
        let times_s = [0, 1].map(|capture| scene.times_s(6 + draw.below(5), capture, draw));
        Box::new(FrictionDropouts { times_s, length_s: draw.uniform(0.03, 0.12) })
    },
};

struct FrictionDropouts {
    times_s: [Vec<f64>; 2],
    length_s: f64,
}

impl Acts for FrictionDropouts {
    fn size_limits(&self) -> [f64; 2] {
        [1e-4, 0.9]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"depth": size, "times_s": self.times_s, "length_s": self.length_s})
    }

    fn friction_factor(&self, size: f64, state: &State, _: bool) -> f64 {
        let mut starts = self.times_s[state.capture].iter();
        1.0 - size * f64::from(starts.any(|start| (*start..start + self.length_s).contains(&state.time_s)))
    }
}
