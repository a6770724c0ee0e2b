//! Rows that repeat the row before them now and then: a logger asked again before its sensors had read anew.
//!
//! A sensor's value held over a regular number of samples is found in [`super::sampling`]. Where the repeated rows follow no rule, the others
//! are readings at uneven times, which are put on an even grid of their mean distance.

use super::clock::{between, typical_step};
use crate::samples::{FEWEST_SAMPLES, PickedSamples, Samples};

/// Share of the rows that must repeat the row before: fewer do no harm.
const LEAST: f64 = 0.02;
/// The torque may repeat by chance, where the angle has changed, in this share of the repeated rows' share at most: a coarse sensor often reads the
/// same twice.
const BY_CHANCE: f64 = 0.1;
/// Longest run of repeated rows; in a longer one the knob rests.
const LONGEST_RUN: usize = 10;

/// The readings on an even grid, and a sentence that says so; `None` if rows repeat seldom or by chance, or times are uneven already.
pub(super) fn without_repeated_rows(samples: &Samples<'_>) -> Option<(PickedSamples, String)> {
    let indices = readings(samples)?;
    let count = samples.t_s.len();
    let (row_s, is_regular) = typical_step(samples.t_s);
    if indices.len() < FEWEST_SAMPLES || !is_regular {
        return None;
    }
    let picked = PickedSamples::of(samples, &indices);
    let readings = picked.samples();
    let (time, last) = (readings.t_s, indices.len() - 1);
    let step_s = (time[last] - time[0]) / last as f64;
    let mut index = 0;
    let points: Vec<(usize, f64)> = (0..=last)
        .map(|point| {
            let at_s = (time[0] + point as f64 * step_s).min(time[last]);
            while index + 1 < last && time[index + 1] <= at_s {
                index += 1;
            }
            (index, at_s)
        })
        .collect();
    let even = |column: &[f64]| {
        // Readings up to three rows apart are near.
        let at = |(index, at_s): &(usize, f64)| between(time, column, *index, *at_s, 2.0 * row_s);
        points.iter().map(at).collect()
    };
    let note = format!(
        "{:.0} % of the rows repeat the row before: only the {} others were used, as readings at uneven times",
        100.0 * (count - indices.len()) as f64 / count as f64,
        indices.len()
    );
    Some((PickedSamples::mapped(&readings, even), note))
}

/// The rows that do not repeat the row before in every column; `None` if too few rows do, or some may by chance.
fn readings(samples: &Samples<'_>) -> Option<Vec<usize>> {
    let Samples { t_s, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm } = *samples;
    let columns = [Some(angle_rad), velocity_rad_s, acceleration_rad_s2, Some(torque_mnm)];
    let repeats = |column: &[f64], row: usize| column[row] == column[row - 1];
    let rows: Vec<usize> = (0..t_s.len()).collect();
    let runs = rows.chunk_by(|_, row| columns.iter().flatten().all(|column| repeats(column, *row)));
    let indices: Vec<usize> =
        runs.flat_map(|run| if run.len() > LONGEST_RUN { run } else { &run[..1] }).copied().collect();
    let moved = || (1..t_s.len()).filter(|row| !repeats(angle_rad, *row));
    let by_chance = moved().filter(|row| repeats(torque_mnm, *row)).count() as f64 / moved().count().max(1) as f64;
    let share = 1.0 - indices.len() as f64 / t_s.len() as f64;
    (share > LEAST && by_chance < BY_CHANCE * share).then_some(indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_repeated_at_random_are_no_readings_but_those_of_a_resting_or_coarse_sensor_are() {
        let angle = |sample: usize| (0.01 * sample as f64).sin();
        let noise = |sample: usize| ((sample * 7919) % 1009) as f64 / 1009.0;
        let t_s: Vec<f64> = (0..4000).map(|sample| 1e-3 * f64::from(sample)).collect();
        let found = |angle_rad: &[f64], torque_mnm: &[f64]| {
            let samples = Samples { t_s: &t_s, angle_rad, velocity_rad_s: None, acceleration_rad_s2: None, torque_mnm };
            without_repeated_rows(&samples)
        };
        let angle_rad: Vec<f64> = (0..4000).map(angle).collect();
        let torque_mnm: Vec<f64> = (0..4000).map(|sample| 5.0 * angle(sample) + noise(sample)).collect();
        assert!(found(&angle_rad, &torque_mnm).is_none());
        let coarse = |column: &[f64], step: f64| column.iter().map(|value| (value / step).round() * step).collect();
        let (coarse_rad, coarse_mnm): (Vec<f64>, Vec<f64>) = (coarse(&angle_rad, 0.05), coarse(&torque_mnm, 2.0));
        assert!(found(&coarse_rad, &coarse_mnm).is_none(), "a coarse sensor reads the same by chance");
        // A third of the rows repeat the row before.
        let mut reading = 0;
        let of_row: Vec<usize> = (0..4000)
            .map(|row| {
                reading = if noise(3 * row + 1) < 0.33 { reading } else { row };
                reading
            })
            .collect();
        let repeated = |column: &[f64]| of_row.iter().map(|reading| column[*reading]).collect::<Vec<f64>>();
        let even = found(&repeated(&angle_rad), &repeated(&torque_mnm));
        assert!(even.is_some());
        let Some((even, note)) = even else { return };
        let even = even.samples();
        assert!(typical_step(even.t_s).1 && (2500..2900).contains(&even.t_s.len()), "{note}");
        let farthest = even.t_s.iter().zip(even.angle_rad).map(|(t_s, at)| (at - (10.0 * t_s).sin()).abs());
        assert!(farthest.fold(0.0, f64::max) < 1e-4, "{note}");
    }
}
