//! Friction that builds up with speed, as a lubricated contact's does beyond its slowest creep.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `velocity-strengthening`.
pub(super) static KIND: Kind = Kind {
    name: "velocity-strengthening",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |_, draw| Box::new(VelocityStrengthening { speed_rad_s: draw.log_uniform(0.3, 2.0) }),
};

struct VelocityStrengthening {
    speed_rad_s: f64,
}

impl Acts for VelocityStrengthening {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 150.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"extra_mnm": size, "speed_rad_s": self.speed_rad_s})
    }

    fn friction_extra(&self, size: f64, state: &State) -> f64 {
        size - size * (-state.velocity_rad_s.abs() / self.speed_rad_s).exp()
    }
}
