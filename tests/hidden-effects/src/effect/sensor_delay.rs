//! A torque sensor that is late.

use serde_json::{Value, json};

use super::{Acts, Kind, between};
use crate::knob::{Knob, Wish};
use crate::plant::STEP_S;

/// `sensor-delay`.
pub(super) static KIND: Kind =
    Kind { name: "sensor-delay", in_catalogue: true, wish: |_| Wish::default(), draw: |_, _| Box::new(SensorDelay) };

struct SensorDelay;

impl Acts for SensorDelay {
    fn size_limits(&self) -> [f64; 2] {
        [5e-5, 3e-3]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"delay_s": size})
    }

    fn channel(&self, size: f64, torque_mnm: &mut Vec<f64>) {
        let late = size / STEP_S;
        *torque_mnm = (0..torque_mnm.len()).map(|index| between(torque_mnm, index as f64 - late)).collect();
    }
}
