//! A torque sensor that clips.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `sensor-saturation`.
pub(super) static KIND: Kind = Kind {
    name: "sensor-saturation",
    in_catalogue: false,
    wish: |_| Wish::default(),
    draw: |_, _| Box::new(SensorSaturation),
};

struct SensorSaturation;

impl Acts for SensorSaturation {
    fn size_limits(&self) -> [f64; 2] {
        [400.0, 3.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"clip_mnm": size})
    }

    fn reading(&self, size: f64, torque_mnm: f64, _: f64) -> f64 {
        torque_mnm.clamp(-size, size)
    }
}
