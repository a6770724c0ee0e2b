//! Columns of any numbers, as a table may hold them: fitted, counted and read off without a panic.
#![no_main]

use identification::checks::{breakaways, count_detents, free_travel};
use identification::{FitOptions, Samples};
use libfuzzer_sys::fuzz_target;

/// Rows of the sweep that the input changes.
const ROWS: usize = 600;

fuzz_target!(|input: &[u8]| fuzz::bounded(input.len() + 24 * ROWS, || {
    let Some((head, changes)) = input.split_at_checked(24) else { return };
    let number = |bytes: &[u8]| bytes.first_chunk().map_or(0.0, |bytes| f64::from_le_bytes(*bytes));
    let [step_s, angle_scale, torque_scale] = [0, 8, 16].map(|place| number(&head[place..]));
    let sweep = |row: usize| (0.05 * row as f64).sin();
    let mut columns = [
        (0..ROWS).map(|row| row as f64 * step_s).collect::<Vec<_>>(),
        (0..ROWS).map(|row| angle_scale * sweep(row)).collect(),
        (0..ROWS).map(|row| torque_scale * sweep(7 * row)).collect(),
    ];
    // Each change: a column, its first row, how many rows, and what is added to them.
    for change in changes.chunks_exact(12) {
        let first = usize::from(u16::from_le_bytes([change[1], change[2]])) % ROWS;
        let rows = first..(first + usize::from(change[3]) + 1).min(ROWS);
        for value in &mut columns[usize::from(change[0]) % 3][rows] {
            *value += number(&change[4..]);
        }
    }
    let [t_s, angle_rad, torque_mnm] = &columns;
    let samples = Samples { t_s, angle_rad, velocity_rad_s: None, acceleration_rad_s2: None, torque_mnm };
    let _ = identification::fit(&samples, &FitOptions::default());
    let _ = identification::knob_motion(&samples, dynamics::Axis::Rotary, None);
    let _ = (breakaways(&samples, None), count_detents(&samples), free_travel(&samples, None));
}));
