//! A stiff contact beyond an angle.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `end-stop`.
pub(super) static KIND: Kind = Kind {
    name: "end-stop",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |scene, draw| {
        let which = draw.below(3);
        let stiffness_mnm_rad = draw.log_uniform(120.0, 1200.0);
        Box::new(EndStop {
            stiffness_mnm_rad,
            damping_mnm_s_rad: stiffness_mnm_rad * draw.log_uniform(1e-3, 8e-3),
            upper: which != 1,
            lower: which != 0,
            travel_rad: scene.travel_rad,
        })
    },
};

struct EndStop {
    stiffness_mnm_rad: f64,
    damping_mnm_s_rad: f64,
    upper: bool,
    lower: bool,
    travel_rad: [f64; 2],
}

impl EndStop {
    /// The stops' angles, `[lower, upper]`, rad.
    fn stops(&self, size: f64) -> [Option<f64>; 2] {
        let [lowest, highest] = self.travel_rad;
        [self.lower.then_some(lowest + size), self.upper.then_some(highest - size)]
    }
}

impl Acts for EndStop {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 0.35 * (self.travel_rad[1] - self.travel_rad[0])]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        let [lower, upper] = self.stops(size);
        json!({"upper_rad": upper, "lower_rad": lower,
            "stiffness_mnm_rad": self.stiffness_mnm_rad, "damping_mnm_s_rad": self.damping_mnm_s_rad})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        let contact = |depth: f64, speed: f64| {
            if depth > 0.0 { (self.stiffness_mnm_rad * depth + self.damping_mnm_s_rad * speed).max(0.0) } else { 0.0 }
        };
        let [lower, upper] = self.stops(size);
        upper.map_or(0.0, |stop| contact(state.angle_rad - stop, state.velocity_rad_s))
            - lower.map_or(0.0, |stop| contact(stop - state.angle_rad, -state.velocity_rad_s))
    }
}
