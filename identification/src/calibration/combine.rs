//! One calibration of several captures.

use super::estimate::{Calibrated, Estimate};
use crate::average::{Combined, combined, wrapped};

/// Combines what several captures tell of the same rig; `None` for none.
///
/// Each quantity is weighted by its interval; where captures disagree beyond their intervals the
/// combined one is wider. Phases are combined on the circle.
#[must_use]
pub fn combine(captures: &[Calibrated]) -> Option<Calibrated> {
    let first = captures.first()?;
    let mut estimates: Vec<Estimate> = Vec::new();
    for estimate in captures.iter().flat_map(|capture| &capture.estimates) {
        if estimates.iter().any(|known| known.quantity == estimate.quantity) {
            continue;
        }
        let told: Vec<(f64, f64)> = captures
            .iter()
            .filter_map(|capture| capture.get(estimate.quantity))
            .map(|other| (near(estimate, other.value), other.half_width))
            .collect();
        let Combined { value, half_width } = combined(&told);
        estimates.push(Estimate { value: on_circle(estimate, value), half_width, ..*estimate });
    }
    let mut notes = first.notes.clone();
    for note in captures.iter().skip(1).flat_map(|capture| &capture.notes) {
        if !notes.contains(note) {
            notes.push(note.clone());
        }
    }
    Some(Calibrated { estimates, notes })
}

fn is_phase(estimate: &Estimate) -> bool {
    estimate.quantity == "gravity_phase_rad"
}

/// A phase on the same turn as the first one; anything else as it is.
fn near(first: &Estimate, value: f64) -> f64 {
    if is_phase(first) { first.value + wrapped(value - first.value) } else { value }
}

fn on_circle(first: &Estimate, value: f64) -> f64 {
    if is_phase(first) { wrapped(value) } else { value }
}
