//! One calibration of several captures.

use super::estimate::{Calibrated, CoggingEstimate, Estimate};
use crate::average::{Estimated, combined};
use crate::numerics::statistics::{mean_angle, nearest_turn};

/// Combines the calibrations from several captures of the same rig; `None` for none.
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
        let all = captures.iter().filter_map(|capture| capture.get(estimate.quantity));
        let all: Vec<(f64, f64)> = all.map(|other| (other.value, other.half_width)).collect();
        let Estimated { value, half_width } =
            if estimate.quantity == "gravity_phase_rad" { combined_on_circle(all) } else { combined(&all) };
        estimates.push(Estimate { value, half_width, ..*estimate });
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
        let phases = same.iter().map(|one| (one.phase_rad, one.phase_half_width_rad)).collect();
        let (torque, phase) = (combined(&torques), combined_on_circle(phases));
        harmonics.push(CoggingEstimate {
            per_turn: first.per_turn,
            torque_mnm: torque.value,
            torque_half_width_mnm: torque.half_width,
            phase_rad: phase.value,
            phase_half_width_rad: phase.half_width,
        });
    }
    harmonics.sort_by(|one, other| other.torque_mnm.total_cmp(&one.torque_mnm));
    Some(harmonics)
}

/// [`combined`] of phases with half widths, all of them within half a turn of their mean.
fn combined_on_circle(mut phases: Vec<(f64, f64)>) -> Estimated {
    let centre_rad = mean_angle(phases.iter().map(|phase| (phase.0, 1.0)));
    phases.iter_mut().for_each(|phase| phase.0 = nearest_turn(phase.0, centre_rad));
    let Estimated { value, half_width } = combined(&phases);
    Estimated { value: nearest_turn(value, 0.0), half_width }
}
