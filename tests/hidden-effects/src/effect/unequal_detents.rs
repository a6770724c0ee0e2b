//! Detents of which each has its own pitch and height, as an indexing wheel is made within its tolerances.

use std::f64::consts::{PI, TAU};

use serde_json::{Value, json};

use super::{Acts, Kind};
use crate::knob::{Knob, Wish};

/// Largest shift of a detent's end, in pitches, and largest relative change of its height, at size 1: what data sheets
/// of detented encoders allow, ±3° of 30° and ±20 %.
const SHIFT: f64 = 0.1;
const HEIGHT: f64 = 0.2;

/// `unequal-detents`.
pub(super) static KIND: Kind = Kind {
    name: "unequal-detents",
    in_catalogue: true,
    wish: |size_mnm| Wish { detents: Some(true), least_detent_mnm: 5.0 * size_mnm, ..Wish::default() },
    draw: |scene, draw| {
        let in_turn = (1.0 / scene.knob.detent_period.unwrap_or(1.0)).round().max(1.0) as usize;
        let mut each = || (0..in_turn).map(|_| draw.uniform(-1.0, 1.0)).collect::<Vec<f64>>();
        let (shifts, heights) = (each(), each());
        // A detent ends where the knob would rest, or on the wall between two rests.
        Box::new(UnequalDetents { shifts, heights, end: if draw.chance(0.5) { PI } else { 0.0 } })
    },
};

struct UnequalDetents {
    shifts: Vec<f64>,
    heights: Vec<f64>,
    end: f64,
}

impl Acts for UnequalDetents {
    fn size_limits(&self) -> [f64; 2] {
        [1e-3, 2.0]
    }

    fn parameters(&self, size: f64, _: &Knob) -> Value {
        let scaled = |values: &[f64], by: f64| values.iter().map(|value| size * by * value).collect::<Vec<f64>>();
        json!({"shift_pitches": scaled(&self.shifts, SHIFT), "relative_height": scaled(&self.heights, HEIGHT),
            "ends_on_walls": self.end > 0.0})
    }

    fn detent_wave(&self, size: f64, x: f64, _: f64) -> Option<f64> {
        let of = |values: &[f64], detent: f64| values[detent.rem_euclid(values.len() as f64) as usize];
        let begin = |detent: f64| TAU * (detent + size * SHIFT * of(&self.shifts, detent)) + self.end;
        let mut detent = ((x - self.end) / TAU).floor();
        if x < begin(detent) {
            detent -= 1.0;
        } else if x >= begin(detent + 1.0) {
            detent += 1.0;
        }
        let (from, to) = (begin(detent), begin(detent + 1.0));
        let height = 1.0 + size * HEIGHT * of(&self.heights, detent);
        Some(height * (TAU * (x - from) / (to - from) + self.end).sin())
    }
}
