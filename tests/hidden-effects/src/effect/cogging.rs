//! Magnets of the motor that pull towards its teeth, in one to three lines.

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
        let mut lines: Vec<Line> = Vec::new();
        let count = 1 + draw.below(3);
        while lines.len() < count {
            let periods_per_turn = unrelated_periods(scene.knob, draw);
            if lines.iter().all(|line| (line.periods_per_turn - periods_per_turn).abs() > CLOSEST) {
                let share = if lines.is_empty() { 1.0 } else { draw.uniform(0.4, 1.0) };
                lines.push(Line { share, periods_per_turn, phase_rad: draw.phase() });
            }
        }
        Box::new(Cogging { lines })
    },
};

/// Lines that are closer than so many periods per turn look like one over the travel.
const CLOSEST: f64 = 4.0;

struct Cogging {
    lines: Vec<Line>,
}

struct Line {
    /// Amplitude over that of the first line.
    share: f64,
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
        let line = |line: &Line| json!({"amplitude_mnm": size * line.share, "periods_per_turn": line.periods_per_turn, "phase_rad": line.phase_rad});
        json!({"lines": self.lines.iter().map(line).collect::<Vec<_>>()})
    }

    fn body_torque(&self, size: f64, state: &State) -> f64 {
        let line = |line: &Line| line.share * (line.periods_per_turn * state.angle_rad + line.phase_rad).sin();
        size * self.lines.iter().map(line).sum::<f64>()
    }
}
