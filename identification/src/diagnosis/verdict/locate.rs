//! Where the residual lies: as a map over everything that it might depend on.

use std::f64::consts::TAU;

use crate::diagnosis::capture::periodogram::periodogram;
use crate::diagnosis::capture::{Capture, SLIDING};
use crate::diagnosis::model_fit::structure::Structure;
use crate::numerics::statistics::{false_discovery_rate, mean_over_error, median, student_above};
use crate::numerics::vector::square;

/// Bins of a coordinate, each with as many rows.
const BINS: usize = 24;
/// Parts of the capture that are left out in turn when a map is tested …
const FOLDS: usize = 12;
/// … each of one stretch; for a map over time, of this many spread over the capture, so that every bin has rows in other parts.
const STRETCHES_IN_TIME: usize = 6;
/// Lines on each side of a line from which the level of the spectrum there is estimated.
const NEIGHBOURS: usize = 40;
/// Fewest of them on each side.
const FEWEST_NEIGHBOURS: usize = 8;
/// Points of a spectrum that are kept for plots.
const SPECTRUM_POINTS: usize = 200;
/// Lines over which Hann's window spreads a sinusoid's power.
const HANN_WIDTH: f64 = 1.5;
/// Share of false discoveries that is accepted among the coordinates named.
const FALSE_DISCOVERIES: f64 = 0.05;

/// How much of the gap a coordinate explains, and its shape.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Location {
    /// The coordinate over which the residual is mapped.
    pub coordinate: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Share of the residual's mean square that the map predicts in stretches that it was not made from, %.
    pub explained_percent: f64,
    /// Probability that a residual that does not depend on the coordinate would be predicted as well.
    #[serde(deserialize_with = "crate::diagnosis::findings::number_or_nan")]
    pub p_value: f64,
    /// Whether the coordinate is named with at most one false discovery in twenty (Benjamini and Hochberg 1995).
    pub significant: bool,
    /// The map: middle of a bin, and mean residual there, mNm.
    pub map: Vec<[f64; 2]>,
}

/// Maps a residual over all coordinates, the one that explains most first.
pub(crate) fn locate(residual: &[f64], structure: &Structure, capture: &Capture) -> Vec<Location> {
    let rows = capture.row_motions();
    let kept: Vec<usize> = (0..rows.len().min(residual.len())).filter(|index| rows[*index].1 > SLIDING).collect();
    let values: Vec<f64> = kept.iter().map(|index| residual[*index]).collect();
    let take = |of: &dyn Fn(usize) -> f64| -> Vec<f64> { kept.iter().map(|index| of(*index)).collect() };
    let travel = travel_since_reversal(&rows.iter().map(|(motion, _)| motion.angle_rad).collect::<Vec<_>>());
    let load = capture.target(structure.delay_s());
    let motion = |index: usize| rows[index].0;
    let mut coordinates: Vec<(&'static str, &'static str, Vec<f64>)> = vec![
        ("angle", "rad", take(&|index| motion(index).angle_rad)),
        ("velocity", "rad/s", take(&|index| motion(index).velocity_rad_s)),
        ("speed-and-direction-of-acceleration", "rad/s", {
            // Loops of hysteresis and inertia: the same speed, gaining or losing.
            take(&|index| motion(index).velocity_rad_s.abs() * motion(index).acceleration_rad_s2.signum())
        }),
        ("acceleration", "rad/s²", take(&|index| motion(index).acceleration_rad_s2)),
        ("travel-since-reversal", "rad", take(&|index| travel[index])),
        ("load", "mNm", take(&|index| load[index])),
        ("time", "s", take(&|index| capture.start_s + motion(index).time_s)),
    ];
    if capture.scene.is_rotary {
        coordinates.push(("angle-within-turn", "rad", take(&|index| motion(index).angle_rad.rem_euclid(TAU))));
    }
    if let Some(period_rad) = structure.parameter("detent_period") {
        let phase = structure.parameter("detent_phase").unwrap_or(0.0);
        let within = |index: usize| (motion(index).angle_rad / period_rad + phase).rem_euclid(TAU);
        coordinates.push(("detent-phase", "rad", take(&within)));
    }
    let mut found: Vec<Location> =
        coordinates.into_iter().map(|(name, unit, at)| mapped(name, unit, &at, &values)).collect();
    found.push(spectrum(residual, &rows, capture));
    let p_values: Vec<f64> = found.iter().map(|location| location.p_value).collect();
    for location in &mut found {
        location.significant = false_discovery_rate(location.p_value, &p_values) <= FALSE_DISCOVERIES;
    }
    found.sort_by(|a, b| b.explained_percent.total_cmp(&a.explained_percent));
    found
}

/// The map over one coordinate, with what it predicts of stretches that it was not made from.
fn mapped(coordinate: &'static str, unit: &'static str, at: &[f64], residual: &[f64]) -> Location {
    let bins = binned(at);
    let stretches = if coordinate == "time" { FOLDS * STRETCHES_IN_TIME } else { FOLDS };
    let stretch = residual.len().div_ceil(stretches).max(1);
    let fold_of = |index: usize| index / stretch % FOLDS;
    let mut sums = vec![[0.0; 2]; BINS * FOLDS];
    for (index, value) in residual.iter().enumerate() {
        let slot = &mut sums[bins[index] * FOLDS + fold_of(index)];
        *slot = [slot[0] + value, slot[1] + 1.0];
    }
    let all: Vec<[f64; 2]> = sums
        .chunks(FOLDS)
        .map(|bin| bin.iter().fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]))
        .collect();
    let mut gains = [0.0; FOLDS];
    for (index, value) in residual.iter().enumerate() {
        let fold = fold_of(index);
        let own = sums[bins[index] * FOLDS + fold];
        let [sum, count] = [all[bins[index]][0] - own[0], all[bins[index]][1] - own[1]];
        let predicted = if count > 0.0 { sum / count } else { 0.0 };
        gains[fold] += value * value - (value - predicted).powi(2);
    }
    let total = square(residual).max(f64::MIN_POSITIVE);
    let mut middles = vec![0.0; BINS];
    at.iter().zip(&bins).for_each(|(value, bin)| middles[*bin] += value);
    Location {
        coordinate,
        unit,
        explained_percent: (100.0 * gains.iter().sum::<f64>() / total).max(0.0),
        p_value: student_above(mean_over_error(&gains), (FOLDS - 1) as f64),
        significant: false,
        map: all
            .iter()
            .zip(middles)
            .filter(|([_, count], _)| *count > 0.0)
            .map(|([sum, count], middle)| [middle / count, sum / count])
            .collect(),
    }
}

/// The residual over frequency: whether one line stands out of its neighbours, as a hum or a ringing does.
fn spectrum(residual: &[f64], rows: &[(dynamics::Motion, f64)], capture: &Capture) -> Location {
    let rate_hz = capture.row_rate_hz();
    let slid: Vec<f64> =
        residual.iter().zip(rows).map(|(value, (_, mask))| if *mask > 0.0 { *value } else { 0.0 }).collect();
    let lines = periodogram(&slid);
    let total: f64 = lines.iter().map(|[_, power]| power).sum::<f64>().max(f64::MIN_POSITIVE);
    let mut strongest = (0.0, 0);
    for (index, [_, power]) in lines.iter().enumerate() {
        // The louder side counts: where noise falls with frequency, every line is higher than those at higher frequencies.
        let sides = [index.saturating_sub(NEIGHBOURS)..index, index + 1..(index + NEIGHBOURS + 1).min(lines.len())];
        if sides.iter().any(|side| side.len() < FEWEST_NEIGHBOURS) {
            continue;
        }
        let level = |side: std::ops::Range<usize>| {
            median(&mut lines[side].iter().map(|[_, power]| *power).collect::<Vec<f64>>())
        };
        let neighbours = sides.map(level).into_iter().fold(f64::MIN_POSITIVE, f64::max);
        // In units of the neighbours' mean: the powers of noise are exponentially distributed, with a median of ln 2 of their mean.
        let height = power * std::f64::consts::LN_2 / neighbours;
        if height > strongest.0 {
            strongest = (height, index);
        }
    }
    let (height, index) = strongest;
    let line = index.saturating_sub(1)..(index + 2).min(lines.len());
    let chance = (-height).exp();
    Location {
        coordinate: "frequency",
        unit: "Hz",
        explained_percent: 100.0 * lines[line].iter().map(|[_, power]| power).sum::<f64>() / total,
        p_value: -(lines.len() as f64 * (-chance).ln_1p()).exp_m1(),
        significant: false,
        map: lines
            .chunks(lines.len().div_ceil(SPECTRUM_POINTS).max(1))
            .map(|part| spectral_point(part, rate_hz, HANN_WIDTH / slid.len() as f64))
            .collect(),
    }
}

/// Frequency in Hz of the strongest of neighbouring lines, and its RMS, mNm.
fn spectral_point(part: &[[f64; 2]], rate_hz: f64, width: f64) -> [f64; 2] {
    let largest = part.iter().fold([0.0, 0.0], |best: [f64; 2], line| if line[1] > best[1] { *line } else { best });
    [largest[0] * rate_hz, (largest[1] * width).sqrt()]
}

/// The bin of every value: as many values in each.
fn binned(values: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut bins = vec![0; values.len()];
    for (rank, index) in order.into_iter().enumerate() {
        bins[index] = rank * BINS / values.len();
    }
    bins
}

/// Angle turned since the last reversal, with the sign of the direction, rad.
fn travel_since_reversal(angle_rad: &[f64]) -> Vec<f64> {
    let mut turned = vec![0.0; angle_rad.len()];
    let mut start = 0;
    for index in 1..angle_rad.len() {
        let step = angle_rad[index] - angle_rad[index - 1];
        let before = angle_rad[index - 1] - angle_rad[start];
        if step * before < 0.0 {
            start = index - 1;
        }
        turned[index] = angle_rad[index] - angle_rad[start];
    }
    turned
}
