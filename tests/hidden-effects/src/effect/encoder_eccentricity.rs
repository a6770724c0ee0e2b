//! An encoder's disc that runs out of true.

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// `encoder-eccentricity`.
pub(super) static KIND: Kind = Kind {
    name: "encoder-eccentricity",
    in_catalogue: false,
    wish: |size_mnm| Wish { detents: Some(true), least_detent_mnm: 4.0 * size_mnm, ..Wish::default() },
    draw: |_, draw| Box::new(EncoderEccentricity { phase_rad: draw.phase() }),
};

struct EncoderEccentricity {
    phase_rad: f64,
}

impl Acts for EncoderEccentricity {
    fn size_limits(&self) -> [f64; 2] {
        [1e-5, 0.15]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"amplitude_rad": size, "phase_rad": self.phase_rad})
    }

    fn encoder(&self, size: f64, angle_rad: f64) -> [f64; 2] {
        let (sine, cosine) = (angle_rad + self.phase_rad).sin_cos();
        [size * sine, size * cosine]
    }
}
