//! Coulomb friction that varies over a turn.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::knob::{Knob, Wish};

/// `friction-eccentricity`.
pub(super) static KIND: Kind = Kind {
    name: "friction-eccentricity",
    in_catalogue: true,
    wish: |size_mnm| Wish { least_coulomb_mnm: 5.0 * size_mnm, ..Wish::default() },
    draw: |_, draw| Box::new(FrictionEccentricity { phase_rad: draw.phase() }),
};

struct FrictionEccentricity {
    phase_rad: f64,
}

impl Acts for FrictionEccentricity {
    fn size_limits(&self) -> [f64; 2] {
        [1e-4, 0.9]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"depth": size, "phase_rad": self.phase_rad})
    }

    fn friction_factor(&self, size: f64, state: &State, viscous: bool) -> f64 {
        if viscous { 1.0 } else { 1.0 + size * (state.angle_rad + self.phase_rad).cos() }
    }
}
