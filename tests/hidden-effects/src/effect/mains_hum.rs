//! Mains hum on the torque sensor.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `mains-hum`.
pub(super) static KIND: Kind = Kind {
    name: "mains-hum",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |_, draw| {
        Box::new(MainsHum { frequency_hz: if draw.chance(0.5) { 50.0 } else { 60.0 }, phase_rad: draw.phase() })
    },
};

struct MainsHum {
    frequency_hz: f64,
    phase_rad: f64,
}

impl Acts for MainsHum {
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
