//! Hum on the torque sensor that is not the mains'.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `strange-hum`.
pub(super) static KIND: Kind = Kind {
    name: "strange-hum",
    in_catalogue: false,
    wish: |_| Wish::default(),
    draw: |_, draw| {
        Box::new(StrangeHum {
            frequency_hz: if draw.chance(0.5) { draw.uniform(20.0, 44.0) } else { draw.uniform(66.0, 140.0) },
            phase_rad: draw.phase(),
        })
    },
};

struct StrangeHum {
    frequency_hz: f64,
    phase_rad: f64,
}

impl Acts for StrangeHum {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 40.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"amplitude_mnm": size, "frequency_hz": self.frequency_hz, "phase_rad": self.phase_rad})
    }

    fn reading(&self, size: f64, torque_mnm: f64, time_s: f64) -> f64 {
        torque_mnm + size * (std::f64::consts::TAU * self.frequency_hz * time_s + self.phase_rad).sin()
    }
}
