//! One calibration of several captures.

use super::estimate::{Calibrated, CoggingEstimate, Estimate};
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
        let estimated: Vec<(f64, f64)> = captures
            .iter()
            .filter_map(|capture| capture.get(estimate.quantity))
            .map(|other| (near(estimate, other.value), other.half_width))
            .collect();
        let Combined { value, half_width } = combined(&estimated);
        estimates.push(Estimate { value: on_circle(estimate, value), half_width, ..*estimate });
    }
    let mut notes = first.notes.clone();
    for note in captures.iter().skip(1).flat_map(|capture| &capture.notes) {
        if !notes.contains(note) {
            notes.push(note.clone());
        }
    }
    Some(Calibrated { estimates, cogging: cogging(captures), notes })
}

/// Each harmonic that any of the captures shows, strongest first.
fn cogging(captures: &[Calibrated]) -> Option<Vec<CoggingEstimate>> {
    let shown: Vec<&Vec<CoggingEstimate>> = captures.iter().filter_map(|capture| capture.cogging.as_ref()).collect();
    if shown.is_empty() {
        return None;
    }
    let mut harmonics: Vec<CoggingEstimate> = Vec::new();
    for first in shown.iter().copied().flatten() {
        if harmonics.iter().any(|known| known.per_turn == first.per_turn) {
            continue;
        }
        let same: Vec<&CoggingEstimate> =
            shown.iter().copied().flatten().filter(|other| other.per_turn == first.per_turn).collect();
        let torques: Vec<(f64, f64)> = same.iter().map(|one| (one.torque_mnm, one.torque_half_width_mnm)).collect();
        let phases: Vec<(f64, f64)> = same
            .iter()
            .map(|one| (first.phase_rad + wrapped(one.phase_rad - first.phase_rad), one.phase_half_width_rad))
            .collect();
        let (torque, phase) = (combined(&torques), combined(&phases));
        harmonics.push(CoggingEstimate {
            per_turn: first.per_turn,
            torque_mnm: torque.value,
            torque_half_width_mnm: torque.half_width,
            phase_rad: wrapped(phase.value),
            phase_half_width_rad: phase.half_width,
        });
    }
    harmonics.sort_by(|one, other| other.torque_mnm.total_cmp(&one.torque_mnm));
    Some(harmonics)
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
