//! A strain gauge whose backing creeps elastically and slips.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `sensor-hysteresis`.
pub(super) static KIND: Kind = Kind {
    name: "sensor-hysteresis",
    in_catalogue: false,
    wish: |_| Wish::default(),
    draw: |_, draw| Box::new(SensorHysteresis { width_mnm: draw.uniform(5.0, 40.0) }),
};

struct SensorHysteresis {
    width_mnm: f64,
}

impl Acts for SensorHysteresis {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 60.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"height_mnm": size, "width_mnm": self.width_mnm})
    }

    fn channel(&self, size: f64, torque_mnm: &mut Vec<f64>) {
        // A Dahl element driven by the torque.
        let (mut pulled, mut before) = (0.0, torque_mnm[0]);
        for torque in torque_mnm {
            let change = *torque - before;
            before = *torque;
            pulled += (change - change.abs() * pulled) / self.width_mnm;
            *torque += size * pulled;
        }
    }
}
