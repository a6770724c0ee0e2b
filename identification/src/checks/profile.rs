//! Torque over angle, by direction.

use std::f64::consts::TAU;

use dynamics::Direction;

use crate::preparation::spectrum::line;
use crate::samples::{Samples, span};
use crate::uncertainty::statistics::{mean, median, running, runs};

/// Bins of angle in one turn: a detent needs some ten of them.
pub(super) const BINS_PER_TURN: f64 = 1440.0;
/// Time after missed ticks in which the torque is the servo's, catching up, and not the knob's, s.
const CATCHING_UP_S: f64 = 0.02;
/// A crossing counts once the torque has passed this share of the detents' amplitude on both sides.
const HYSTERESIS: f64 = 0.4;
/// Bins on either side over which the torque's median is taken, so that single shocks do not count, …
const MEDIAN_REACH: usize = 2;
/// … and over which it is then averaged before it is counted.
const MEAN_REACH: usize = 1;
/// Longest hole in the passed angles that is bridged, bins: 2°.
const LONGEST_BRIDGE: usize = 8;

/// Torque over angle where the knob passed both ways.
pub(super) struct Profile {
    first_rad: f64,
    /// Mean of both directions' torques, bin by bin, without its straight line, mNm.
    pub(super) mean_mnm: Vec<f64>,
    /// Correlation of the two directions' torques over angle.
    pub(super) correlation: f64,
}

impl Profile {
    pub(super) fn of(samples: &Samples<'_>) -> Self {
        let lowest = samples.angle_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let width = TAU / BINS_PER_TURN;
        let bin = |angle: f64| ((angle - lowest) / width) as usize;
        let bins = (span(samples.angle_rad) / width) as usize + 1;
        let (mut sums, mut counts) = ([vec![0.0; bins], vec![0.0; bins]], [vec![0.0; bins], vec![0.0; bins]]);
        // The direction of a sample is that in which the knob leaves its bin's neighbourhood, not that of encoder steps.
        let mut turning_point = samples.angle_rad[0];
        let mut direction = None;
        let mut steps: Vec<f64> = samples.t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let step_s = median(&mut steps);
        let (mut previous_s, mut caught_up_s) = (samples.t_s[0], samples.t_s[0]);
        for ((time_s, angle), torque) in samples.t_s.iter().zip(samples.angle_rad).zip(samples.torque_mnm) {
            if time_s - previous_s > 1.5 * step_s {
                caught_up_s = time_s + CATCHING_UP_S;
            }
            previous_s = *time_s;
            let away = angle - turning_point;
            let onwards = match direction {
                Some(Direction::Positive) => away > 0.0,
                Some(Direction::Negative) => away < 0.0,
                None => false,
            };
            if onwards {
                turning_point = *angle;
            } else if away.abs() > 2.0 * width {
                direction = Some(Direction::of(away));
                turning_point = *angle;
            }
            let side = match direction {
                Some(Direction::Negative) => 0,
                Some(Direction::Positive) => 1,
                None => continue,
            };
            if *time_s >= caught_up_s {
                sums[side][bin(*angle)] += torque;
                counts[side][bin(*angle)] += 1.0;
            }
        }
        let sides = [0, 1].map(|side| {
            let passed = sums[side].iter().zip(&counts[side]);
            bridged(&passed.map(|(sum, count)| (*count > 0.0).then(|| sum / count)).collect::<Vec<_>>())
        });
        let both: Vec<bool> = (0..bins).map(|at| sides[0][at].is_some() && sides[1][at].is_some()).collect();
        let passed = runs(&both, |one, other| one == other).filter(|run| both[run.start]);
        let run = passed.reduce(|longest, run| if run.len() > longest.len() { run } else { longest }).unwrap_or(0..0);
        let side = |side: usize| {
            let torque: Vec<f64> = sides[side][run.clone()].iter().copied().flatten().collect();
            let without_shocks = running(&torque, MEDIAN_REACH, |near| median(&mut near.to_vec()));
            without_line(&running(&without_shocks, MEAN_REACH, |near| mean(near)))
        };
        let (back, there) = (side(0), side(1));
        let product = |left: &[f64], right: &[f64]| left.iter().zip(right).map(|(a, b)| a * b).sum::<f64>();
        let scale = (product(&back, &back) * product(&there, &there)).sqrt();
        let mean: Vec<f64> = back.iter().zip(&there).map(|(a, b)| 0.5 * (a + b)).collect();
        Self {
            first_rad: lowest + (run.start as f64 + 0.5) * width,
            mean_mnm: mean,
            correlation: if scale > 0.0 { product(&back, &there) / scale } else { 0.0 },
        }
    }

    /// Angles at which the torque rises through its mean, rad.
    pub(super) fn rising_crossings(&self) -> Vec<f64> {
        let mean_mnm = &self.mean_mnm;
        // Half of a sine's values lie below its amplitude over √2, shocks or not.
        let mut sizes: Vec<f64> = mean_mnm.iter().map(|torque| torque.abs()).collect();
        let threshold = HYSTERESIS * std::f64::consts::SQRT_2 * median(&mut sizes);
        let mut crossings = Vec::new();
        let mut low = false;
        let mut candidate = None;
        for (index, pair) in mean_mnm.windows(2).enumerate() {
            if pair[0] < -threshold {
                (low, candidate) = (true, None);
            }
            if low && pair[0] < 0.0 && pair[1] >= 0.0 {
                let share = pair[0] / (pair[0] - pair[1]);
                candidate = Some(self.first_rad + (index as f64 + share) * TAU / BINS_PER_TURN);
            }
            if pair[1] > threshold
                && let Some(angle) = candidate.take()
            {
                crossings.push(angle);
                low = false;
            }
        }
        crossings
    }
}

/// The values with short holes bridged by straight lines: missed ticks and slips leave such.
fn bridged(values: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut bridged = values.to_vec();
    let mut before: Option<(usize, f64)> = None;
    for (index, value) in values.iter().enumerate() {
        let Some(value) = *value else { continue };
        if let Some((from, start)) = before
            && index - from <= LONGEST_BRIDGE
        {
            let slope = (value - start) / (index - from) as f64;
            (from + 1..index).for_each(|at| bridged[at] = Some(start + slope * (at - from) as f64));
        }
        before = Some((index, value));
    }
    bridged
}

/// The signal without its straight line.
fn without_line(signal: &[f64]) -> Vec<f64> {
    let places: Vec<f64> = (0..signal.len()).map(|at| at as f64).collect();
    let (mean, slope) = line(signal, &places);
    let middle = 0.5 * (signal.len() as f64 - 1.0);
    signal.iter().zip(&places).map(|(value, at)| value - mean - slope * (at - middle)).collect()
}
