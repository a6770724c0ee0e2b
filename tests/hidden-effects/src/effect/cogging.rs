//! Magnets of the motor that pull towards its teeth.

use serde_json::{Value, json};

use super::{Acts, Kind, State};
use crate::draw::Draw;
use crate::knob::{Knob, Wish};

/// `cogging`.
pub(super) static KIND: Kind = Kind {
    name: "cogging",
    in_catalogue: true,
    // The base model would take it for detents if the knob had none of its own.
    wish: |_| Wish { detents: Some(true), ..Wish::default() },
    draw: |scene, draw| {
        Box::new(Cogging { periods_per_turn: unrelated_periods(scene.knob, draw), phase_rad: draw.phase() })
    },
};

struct Cogging {
    periods_per_turn: f64,
    phase_rad: f64,
}

/// Whole periods per turn that are no multiple of the detents', nor near one.
fn unrelated_periods(knob: &Knob, draw: &mut Draw) -> f64 {
    loop {
        let periods = (5 + draw.below(56)) as f64;
        let ratio = knob.detent_period.map_or(0.5, |period| periods * period);
        let nearest = ratio.round().max(1.0);
        if (ratio - nearest).abs() > 0.12 * nearest.min(2.0) {
            return periods;
        }
    }
}

impl Acts for Cogging {
    fn size_limits(&self) -> [f64; 2] {
        [1e-2, 40.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        json!({"amplitude_mnm": size, "periods_per_turn": self.periods_per_turn, "phase_rad": self.phase_rad})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        size * (self.periods_per_turn * state.angle_rad + self.phase_rad).sin()
    }
}
