//! The sinusoids of the angle in a torque, with intervals: found one after the other, all of them fitted anew each time.
//!
//! Orthogonal matching pursuit (Y. C. Pati, R. Rezaiifar, P. S. Krishnaprasad, 27th Asilomar Conference, 1993): the
//! strongest sinusoid in what the others leave joins, then all coefficients are solved together.

use std::f64::consts::{PI, TAU};

use super::{MARGIN, PREDICTS, noise_variance, threshold};
use crate::estimate::Harmonic;
use crate::numerics::statistics::{deviation_of_sum, interval, median};
use crate::numerics::{fourier, vector};
use crate::regression::block_sums::{BlockSums, Estimate, critical};
use crate::regression::refiner::{self, Ended, longest_improving};
use crate::samples::span;

/// Bins of angle in which the residual is summed for the transform.
const BINS: usize = 16_384;
/// Highest line of the transform that is looked at: summing within a bin takes 3 % off there.
const HIGHEST: usize = BINS / 8;
/// Share of a turn from which it counts as whole.
const WHOLE_TURN: f64 = 0.98;
/// Without a whole turn, wavenumbers are real: the travel is padded to this many times its length …
const PADDING: f64 = 4.0;
/// … and must hold this many periods.
const FEWEST_PERIODS: f64 = 2.0;
/// A sinusoid that explains less than this share of what the others leave is not worth a line of the table: of the
/// thousands tried, the best one explains a little of anything.
const WORTHWHILE: f64 = 0.01;
/// The pursuit ends after so many sinusoids in a row that do not predict.
const REFUSALS: usize = 4;
/// No more sinusoids than this.
const MOST: usize = 64;
/// Gauss–Newton steps of a real wavenumber.
const STEPS: usize = 8;
/// A step that takes off less than this share of the sum of squares is the last.
const SETTLED: f64 = 1e-9;

/// The wavenumbers at which sinusoids are looked for.
pub(crate) struct Grid {
    /// Wavenumber of the transform's first line, 1/rad: 1 for whole turns.
    unit: f64,
    /// First and last line that is looked at.
    lowest: usize,
    highest: usize,
    /// Smallest angle, rad.
    start_rad: f64,
    pub(crate) whole_turn: bool,
}

impl Grid {
    pub(crate) fn of(angle_rad: &[f64]) -> Self {
        let travel = span(angle_rad);
        let whole_turn = travel >= WHOLE_TURN * TAU;
        let unit = if whole_turn { 1.0 } else { TAU / (PADDING * travel) };
        let lowest = if whole_turn { 1 } else { (FEWEST_PERIODS * PADDING) as usize };
        let mut steps: Vec<f64> =
            angle_rad.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0).collect();
        // Two steps in a period, at least.
        let finest = (PI / median(&mut steps) / unit).min(HIGHEST as f64) as usize;
        let start_rad = vector::extent(angle_rad).map_or(0.0, |(lowest, _)| lowest);
        Self { unit, lowest, highest: finest.max(lowest), start_rad, whole_turn }
    }

    /// The grid without the wavenumbers above `wavenumber`, 1/rad.
    pub(crate) fn up_to(self, wavenumber: f64) -> Self {
        Self { highest: self.highest.min((wavenumber / self.unit) as usize).max(self.lowest), ..self }
    }

    /// The wavenumber (1/rad) whose sinusoid explains most of the residual, if it stands out.
    fn strongest(&self, angle_rad: &[f64], residual: &[f64], taken: &[f64]) -> Option<f64> {
        let transform = fourier::forward(BINS);
        let (mut sums, mut lines) = (transform.make_input_vec(), transform.make_output_vec());
        for (angle, rest) in angle_rad.iter().zip(residual) {
            let turns = (angle - self.start_rad) * self.unit / TAU;
            sums[((turns - turns.floor()) * BINS as f64) as usize % BINS] += rest;
        }
        transform.process(&mut sums, &mut lines).ok()?;
        let scale = 2.0 / residual.len() as f64;
        let power = |line: usize| scale * lines[line].norm_sqr();
        let near = if self.whole_turn { 0.5 } else { 0.5 * PADDING };
        let free = |line: &usize| taken.iter().all(|known| (known / self.unit - *line as f64).abs() > near);
        let highest = self.highest.min(lines.len() - 2);
        let best = (self.lowest..=highest).filter(free).max_by(|a, b| power(*a).total_cmp(&power(*b)))?;
        let mut powers: Vec<f64> = (self.lowest..=highest).map(power).collect();
        let noise = noise_variance(&mut powers);
        let independent = (highest - self.lowest + 1) as f64 / if self.whole_turn { 1.0 } else { PADDING };
        let is_clear = power(best) > threshold(independent, MARGIN) * noise
            && power(best) > WORTHWHILE * residual.iter().map(|rest| rest * rest).sum::<f64>();
        is_clear.then_some(best as f64 * self.unit)
    }
}

/// Adds the sinusoids that stand out and predict stretches to which they were not fitted; returns their wavenumbers, 1/rad.
///
/// The columns of each are sine and cosine, behind those that the sums hold already.
pub(crate) fn sinusoids(sums: &mut BlockSums, angle_rad: &[f64], grid: &Grid) -> Vec<f64> {
    let mut wavenumbers: Vec<f64> = Vec::new();
    let mut tried: Vec<f64> = Vec::new();
    let mut refusals = 0;
    while wavenumbers.len() < MOST && refusals < REFUSALS {
        let Some(solution) = sums.solve() else { break };
        let residual = sums.residual(&solution.coefficients);
        let Some(peak) = grid.strongest(angle_rad, &residual, &tried) else { break };
        let base = sums.width();
        let wavenumber = if grid.whole_turn { peak } else { refined(sums, angle_rad, peak, grid.unit) };
        tried.push(wavenumber);
        push(sums, angle_rad, wavenumber);
        if sums.evidence(base) < PREDICTS {
            sums.truncate(base);
            refusals += 1;
            continue;
        }
        refusals = 0;
        wavenumbers.push(wavenumber);
    }
    wavenumbers
}

/// Adds sine and cosine.
fn push(sums: &mut BlockSums, angle_rad: &[f64], wavenumber: f64) {
    sums.push(angle_rad.iter().map(|angle| (wavenumber * angle).sin()).collect());
    sums.push(angle_rad.iter().map(|angle| (wavenumber * angle).cos()).collect());
}

/// The derivative of a·sin(kθ) + b·cos(kθ) by k, with θ from the middle of the travel, where k and phase are independent.
pub(crate) fn tangent(angle_rad: &[f64], wavenumber: f64, coefficients: [f64; 2]) -> Vec<f64> {
    let middle = vector::extent(angle_rad).map_or(0.0, |(lowest, highest)| 0.5 * (lowest + highest));
    angle_rad
        .iter()
        .map(|angle| {
            let (sine, cosine) = (wavenumber * angle).sin_cos();
            (angle - middle) * (coefficients[0] * cosine - coefficients[1] * sine)
        })
        .collect()
}

/// A real wavenumber, improved by Gauss–Newton steps of at most half a line.
fn refined(sums: &mut BlockSums, angle_rad: &[f64], start: f64, unit: f64) -> f64 {
    let base = sums.width();
    let mut wavenumber = start;
    let left = |sums: &mut BlockSums, wavenumber| {
        push(sums, angle_rad, wavenumber);
        let left = sums.squares_left(&(0..base + 2).collect::<Vec<_>>());
        sums.truncate(base);
        left
    };
    let Some(squares) = left(sums, start) else { return start };
    refiner::refine(STEPS, SETTLED, squares, |before| {
        push(sums, angle_rad, wavenumber);
        let step = sums.solve().and_then(|solution| {
            let [sine, cosine] = [base, base + 1].map(|column| solution.coefficients[column]);
            sums.push(tangent(angle_rad, wavenumber, [sine, cosine]));
            sums.solve().map(|extended| extended.coefficients[base + 2].clamp(-0.5 * unit, 0.5 * unit))
        });
        sums.truncate(base);
        let (from, step) = (wavenumber, step.ok_or(Ended::NoStepImproves)?);
        longest_improving(0.25, |share| {
            wavenumber = from + share * step;
            left(sums, wavenumber).filter(|after| *after < before)
        })
        .inspect_err(|_| wavenumber = from)
    });
    wavenumber
}

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
    let wavenumbers = sinusoids(&mut sums, angle_rad, &grid);
    let estimate = sums.estimate()?;
    ranked(&sums, &estimate, columns, &wavenumbers)
}

/// The sinusoids behind the first `base` columns, strongest first.
pub(crate) fn ranked(sums: &BlockSums, estimate: &Estimate, base: usize, wavenumbers: &[f64]) -> Option<Vec<Harmonic>> {
    let coefficients = &estimate.coefficients;
    let pair = |position: usize| [coefficients[base + 2 * position], coefficients[base + 2 * position + 1]];
    let mut order: Vec<usize> = (0..wavenumbers.len()).collect();
    let size = |position: &usize| pair(*position)[0].hypot(pair(*position)[1]);
    order.sort_by(|a, b| size(b).total_cmp(&size(a)));
    let mut chosen: Vec<usize> = (0..base).collect();
    let total = sums.target_squares();
    let mut before = sums.squares_left(&chosen)?;
    let mut harmonics = Vec::new();
    for position in &order {
        let at = base + 2 * position;
        chosen.extend([at, at + 1]);
        let after = sums.squares_left(&chosen)?;
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
    Some(harmonics)
}

/// Which multiple of the strongest a wavenumber is, if it is one.
fn overtone(wavenumber: f64, strongest: f64) -> Option<u32> {
    let ratio = wavenumber / strongest;
    ((ratio - ratio.round()).abs() < 1e-9 && ratio >= 1.0).then(|| ratio.round() as u32)
}
