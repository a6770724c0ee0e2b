//! What the sinusoids of the angle are, each with its intervals.

use super::block_sums::{BlockSums, Estimate, critical};
use super::matching_pursuit::{self, Grid};
use super::{interval, overtone};
use crate::estimate::Harmonic;
use crate::uncertainty::statistics::deviation_of_sum;

/// The sinusoids of whole turns, strongest first, that a torque over the angle holds beside `base`, the columns of what else
/// acts; up to `finest` periods a turn. All columns have one row length.
///
/// Only those that stand out and predict stretches that they were not fitted to. `None` if the turn is not whole, or the
/// columns cannot be told apart.
pub(crate) fn of_turns(
    base: Vec<Vec<f64>>,
    angle_rad: &[f64],
    torque_mnm: Vec<f64>,
    finest: f64,
) -> Option<Vec<Harmonic>> {
    let columns = base.len();
    let mut sums = BlockSums::new(torque_mnm);
    base.into_iter().for_each(|column| sums.push(column));
    let grid = Grid::of(angle_rad).up_to(finest);
    if !grid.whole_turn {
        return None;
    }
    let wavenumbers = matching_pursuit::sinusoids(&mut sums, angle_rad, &grid);
    let estimate = sums.estimate()?;
    ranked(&sums, &estimate, columns, &wavenumbers).map(|(_, harmonics)| harmonics)
}

/// The sinusoids behind the first `base` columns: their places from the strongest on, and what they are.
pub(super) fn ranked(
    sums: &BlockSums,
    estimate: &Estimate,
    base: usize,
    wavenumbers: &[f64],
) -> Option<(Vec<usize>, Vec<Harmonic>)> {
    let coefficients = &estimate.coefficients;
    let pair = |position: usize| [coefficients[base + 2 * position], coefficients[base + 2 * position + 1]];
    let mut order: Vec<usize> = (0..wavenumbers.len()).collect();
    let size = |position: &usize| pair(*position)[0].hypot(pair(*position)[1]);
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let mut chosen: Vec<usize> = (0..base).collect();
    let total = sums.target_squares();
    let mut before = sums.left(&chosen)?;
    let mut harmonics = Vec::new();
    for position in &order {
        let at = base + 2 * position;
        chosen.extend([at, at + 1]);
        let after = sums.left(&chosen)?;
        let [sine, cosine] = pair(*position);
        let amplitude = sine.hypot(cosine);
        let own = estimate.covariance.view((at, at), (2, 2)).into_owned();
        let half = critical() * deviation_of_sum(&own, &[sine / amplitude, cosine / amplitude]);
        let turn = critical() * deviation_of_sum(&own, &[-cosine / amplitude, sine / amplitude]) / amplitude;
        let phase = cosine.atan2(sine);
        harmonics.push(Harmonic {
            order: overtone(wavenumbers[*position], wavenumbers[order[0]]),
            per_turn: wavenumbers[*position],
            amplitude_mnm: amplitude,
            amplitude_ci95_mnm: Some(interval(amplitude, half)),
            phase_rad: phase,
            phase_ci95_rad: Some(interval(phase, turn)),
            explains_percent: 100.0 * (1.0 - after / before),
            relative_error_percent: Some(100.0 * (after / total).sqrt()),
        });
        before = after;
    }
    Some((order, harmonics))
}
