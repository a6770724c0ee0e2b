//! A knob that slips in its grip now and then.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `grip-slips`.
pub(super) static KIND: Kind = Kind {
    name: "grip-slips",
    in_catalogue: false,
    wish: |size_mnm| Wish { detents: Some(true), least_detent_mnm: 4.0 * size_mnm, ..Wish::default() },
    draw: |scene, draw| {
        let count = 2 + draw.below(2);
        let times_s = [0, 1].map(|capture| scene.times_s(count, capture, draw));
        Box::new(GripSlips { times_s, signs: vec![scene.sign; count] })
    },
};

struct GripSlips {
    times_s: [Vec<f64>; 2],
    signs: Vec<f64>,
}

impl Acts for GripSlips {
    fn size_limits(&self) -> [f64; 2] {
        [1e-4, 0.15]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"slip_rad": size, "times_s": self.times_s, "signs": self.signs})
    }

    fn slipped_rad(&self, size: f64, state: &State) -> f64 {
        let times = self.times_s[state.capture].iter().zip(&self.signs);
        size * times.filter(|(time, _)| **time < state.time_s).map(|(_, sign)| sign).sum::<f64>()
    }
}
