//! The torque sensor's noise, as it shows while the knob rests.

use super::periodogram::periodogram;
use crate::numerics::statistics::{median, runs};
use crate::numerics::vector;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;
use crate::preparation::uniform::Uniform;

/// Shortest rest from which the noise is read, beyond the filter's length, s.
const REST_S: f64 = 0.08;
/// Parts of the rows' spectrum over which medians are taken, in cycles per row; the band ends at two fifths.
const REST_PARTS: [f64; 5] = [0.0, 0.08, 0.18, 0.3, 0.5];
/// Fewest rows at rest from which the noise in the band is believed.
const REST_ROWS: usize = 40;

/// RMS in the rows of the torque's noise while the knob rests; `None` if it hardly ever does.
///
/// A sensor's noise need not be white, so the upper end of its spectrum may give a wrong density for the band below; a rest does
/// not. Medians over parts of the band leave out lines such as hum, which are no noise.
pub(super) fn in_rows_mnm(
    uniform: &Uniform,
    motion: &KnobMotion,
    row_filter: &RowFilter,
    torque_mnm: &[f64],
) -> Option<f64> {
    let shortest = (REST_S * uniform.rate_hz).round() as usize + 2 * row_filter.fir.half_length();
    let speeds = motion.velocity_rad_s.iter().zip(&uniform.present);
    let is_rest: Vec<bool> =
        speeds.map(|(velocity, present)| velocity.abs() <= row_filter.threshold_rad_s && *present).collect();
    // Frequency in cycles per row, and density in mean squares per cycle.
    let mut lines: Vec<[f64; 2]> = Vec::new();
    let mut count = 0;
    for rest in runs(&is_rest, |one, other| one == other).filter(|run| is_rest[run.start]) {
        let settled = rest.start + motion.reach..rest.end.saturating_sub(motion.reach);
        if settled.len() < shortest {
            continue;
        }
        let rows = row_filter.fir.decimate(&torque_mnm[settled.clone()], row_filter.step);
        let margin = row_filter.fir.half_length().div_ceil(row_filter.step);
        let mut inner = rows.get(margin..rows.len().saturating_sub(margin)).unwrap_or(&[]).to_vec();
        // What holds the knob changes slowly.
        remove_parabola(&mut inner);
        lines.extend(periodogram(&inner));
        count += inner.len();
    }
    if count < REST_ROWS {
        return None;
    }
    // A line's power is the sum of the squares of two normal numbers: its median is ln 2 times its mean.
    let mut densities: Vec<f64> = REST_PARTS
        .windows(2)
        .map(|edges| {
            let lines = lines.iter().filter(|[at, _]| (edges[0]..edges[1]).contains(at));
            median(&mut lines.map(|[_, density]| *density).collect::<Vec<f64>>()) / std::f64::consts::LN_2
        })
        .collect();
    // Noise has no redder spectrum than a random walk; a redder one comes from a drive that goes on while the knob sticks.
    let ratio = (REST_PARTS[1] + REST_PARTS[2]) / (REST_PARTS[0] + REST_PARTS[1]);
    densities[0] = densities[0].min(ratio * ratio * densities[1]);
    let parts = REST_PARTS.windows(2).zip(&densities).map(|(edges, density)| (edges[1] - edges[0]) * density);
    Some(parts.sum::<f64>().sqrt())
}

/// Takes the best parabola off evenly spaced values.
fn remove_parabola(values: &mut [f64]) {
    let half = 0.5 * (values.len() as f64 - 1.0).max(1.0);
    let power = |power| (0..values.len()).map(|index| ((index as f64 - half) / half).powi(power)).collect();
    let powers: [Vec<f64>; 3] = [0, 1, 2].map(power);
    vector::take_out(&vector::orthonormal(&powers), values);
}
