//! A torque sensor that follows only so fast.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};
use crate::plant::STEP_S;

/// `rate-limited-sensor`.
pub(super) static KIND: Kind = Kind {
    name: "rate-limited-sensor",
    in_catalogue: false,
    wish: |_| Wish::default(),
    draw: |_, _| Box::new(RateLimitedSensor),
};

struct RateLimitedSensor;

impl Acts for RateLimitedSensor {
    fn size_limits(&self) -> [f64; 2] {
        [2e6, 300.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"limit_mnm_s": size})
    }

    fn channel(&self, size: f64, torque_mnm: &mut Vec<f64>) {
        let most = size * STEP_S;
        let mut held = torque_mnm[0];
        for torque in torque_mnm {
            held += (*torque - held).clamp(-most, most);
            *torque = held;
        }
    }
}
