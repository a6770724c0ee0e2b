//! Eddy currents in a disc that turns past magnets: J. H. Wouterse, IEE Proc. B 138 (1991) 153–158.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `eddy-current-damping`.
pub(super) static KIND: Kind = Kind {
    name: "eddy-current-damping",
    in_catalogue: true,
    wish: |_| Wish::default(),
    draw: |_, draw| Box::new(EddyCurrentDamping { speed_rad_s: draw.log_uniform(1.0, 5.0) }),
};

struct EddyCurrentDamping {
    speed_rad_s: f64,
}

impl Acts for EddyCurrentDamping {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 100.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"damping_mnm_s_rad": size, "speed_rad_s": self.speed_rad_s})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        size * state.velocity_rad_s / (1.0 + (state.velocity_rad_s / self.speed_rad_s).powi(2))
    }
}
