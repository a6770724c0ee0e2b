//! The period of detents, searched over everything that the travel supports, without a starting point.
//!
//! For every wavenumber k = 1/P: what a·sin(kθ) + b·cos(kθ) takes off the sum of squares of the base model's residual r, the
//! periodogram of N. R. Lomb (Astrophys. Space Sci. 39, 1976, 447–462) beside base columns. The rows' filter F moves to the
//! other side of each inner product, ⟨r, F·e^{ikθ}⟩ = ⟨Fᵀr, e^{ikθ}⟩, so that a few Fourier transforms over the angle give all
//! wavenumbers at once.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::DMatrix;

use super::fourier_sums::FourierSums;
use super::reduction::Reduction;
use super::{FEWEST_PERIODS, OVERSAMPLING, noise_variance, vertex};
use crate::numerics::statistics::quantile;
use crate::numerics::vector::{self, dot};
use crate::preparation::band::Band;
use crate::preparation::row_filter::RowFilter;
use crate::regression::problem::Problem;

const LARGEST_TRANSFORM: usize = 1 << 15;
/// Angle bins per period of the finest detent: cubic splines between them are then right to 0.3 %.
const BINS_PER_PERIOD: f64 = 5.2;
/// Base columns are looked at up to this index of a wavenumber, 128 periods in the travel: finer sinusoids have hardly
/// anything in common with them (less than a percent, from the turning points of the sweep).
const MOST_BASE: usize = 512;
/// Factor between two wavenumbers at which the filter's gain is summed over the speeds.
const GAIN_STEP: f64 = 1.03;
/// Share of the samples in which a detent must pass slowly enough for the band.
const SLOW_SHARE: f64 = 0.1;

/// A period that stands out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    /// Wavenumber 1/P, 1/rad.
    pub(crate) wavenumber: f64,
    /// Sum of squares that a detent of this period takes away, mNm².
    pub(crate) power: f64,
}

/// The part of the motion and the base columns that all scans of a capture share.
pub(crate) struct Scan {
    travel_rad: f64,
    /// Distance of two wavenumbers, 1/rad.
    spacing: f64,
    first: usize,
    last: usize,
    sums: FourierSums,
    /// For every wavenumber.
    reductions: Vec<Reduction>,
}

impl Scan {
    /// `inverse` is the inverse of the Gram matrix of the base problem's columns. `None` if the travel supports no period at all.
    pub(crate) fn new(base: &Problem<'_>, inverse: &DMatrix<f64>, band: &Band, angle_step_rad: f64) -> Option<Self> {
        let Problem { row_filter, motion, columns, .. } = base;
        let (offset_rad, _) = vector::extent(&motion.angle_rad)?;
        let (lowest, highest) = vector::extent_where(&motion.angle_rad, &row_filter.mask)?;
        let travel_rad = highest - lowest;
        let at_rows = || (0..motion.len()).step_by(row_filter.step);
        let mut speeds = row_filter.sliding_speeds_rad_s(motion);
        let slow_rad_s = quantile(&mut speeds, SLOW_SHARE);
        let spacing = TAU / (OVERSAMPLING as f64 * travel_rad);
        let highest = (TAU * band.edge_hz / slow_rad_s).min(FRAC_PI_2 / angle_step_rad.max(f64::MIN_POSITIVE));
        let last = (highest / spacing).min(LARGEST_TRANSFORM as f64 / BINS_PER_PERIOD) as usize;
        let first = (OVERSAMPLING as f64 * FEWEST_PERIODS).ceil() as usize;
        if !(travel_rad > 0.0 && last > first) {
            return None;
        }
        // The transform spans OVERSAMPLING × the travel; the full angle range may be a little wider than the sliding one.
        let length = ((BINS_PER_PERIOD * last as f64) as usize).next_power_of_two().clamp(1024, LARGEST_TRANSFORM);
        let base_last = last.min(MOST_BASE);
        let coarse_length = ((2.0 * BINS_PER_PERIOD * base_last as f64) as usize).next_power_of_two();
        let coarse = FourierSums::new(coarse_length, offset_rad, spacing, 2 * base_last);
        // A base column varies slowly, and low wavenumbers pass the rows' filter: rows alone will do.
        let angles: Vec<f64> = at_rows().map(|index| motion.angle_rad[index]).collect();
        let masks: Vec<f64> = at_rows().map(|index| row_filter.mask[index]).collect();
        let columns: Vec<&[f64]> = columns.iter().map(|rows| &**rows).chain([&masks[..]]).collect();
        let mut base = coarse.of_columns(&columns, &angles);
        let weights = base.pop()?;
        let mut scan = Self {
            travel_rad,
            spacing,
            first,
            last,
            sums: FourierSums::new(length, offset_rad, spacing, last),
            reductions: Vec::new(),
        };
        let attenuations = scan.attenuations(row_filter, band, &speeds);
        let reduction =
            |(index, attenuation): (usize, &f64)| Reduction::new(index, *attenuation, &base, &weights, inverse);
        scan.reductions = (first..).zip(&attenuations).map(reduction).collect();
        Some(scan)
    }

    /// Longest and shortest period P that is searched, rad.
    pub(crate) fn periods_rad(&self) -> (f64, f64) {
        (1.0 / (self.first as f64 * self.spacing), 1.0 / (self.last as f64 * self.spacing))
    }

    /// Number of independent periods among those tried.
    pub(crate) fn independent(&self) -> f64 {
        ((self.last - self.first) as f64 / OVERSAMPLING as f64).max(1.0)
    }

    /// Width of a peak, 1/rad.
    pub(crate) fn resolution(&self) -> f64 {
        TAU / self.travel_rad
    }

    /// What a detent at each wavenumber would take off the residual's sum of squares, mNm².
    pub(crate) fn powers(&self, base: &Problem<'_>, residual: &[f64]) -> Vec<f64> {
        let sums = self.sums.of(&base.row_filter.spread(residual), &base.motion.angle_rad);
        self.reductions.iter().zip(&sums[self.first..]).map(|(reduction, sum)| reduction.of(*sum)).collect()
    }

    /// The `count` highest local maxima, highest first.
    pub(crate) fn peaks(&self, powers: &[f64], count: usize) -> Vec<Peak> {
        let mut order: Vec<usize> = (0..powers.len())
            .filter(|index| {
                let left = index.checked_sub(1).map_or(f64::NEG_INFINITY, |left| powers[left]);
                let right = powers.get(index + 1).copied().unwrap_or(f64::NEG_INFINITY);
                powers[*index] > 0.0 && powers[*index] >= left && powers[*index] >= right
            })
            .collect();
        let stronger = |a: &usize, b: &usize| powers[*b].total_cmp(&powers[*a]);
        if order.len() > count {
            order.select_nth_unstable_by(count, stronger);
            order.truncate(count);
        }
        order.sort_by(stronger);
        order
            .into_iter()
            .map(|index| {
                let top = vertex(powers, index);
                Peak { wavenumber: ((index + self.first) as f64 + top) * self.spacing, power: powers[index] }
            })
            .collect()
    }

    /// Largest power within a peak's width of a wavenumber, mNm²; `None` beyond what was searched.
    pub(crate) fn near(&self, powers: &[f64], wavenumber: f64) -> Option<f64> {
        let place = (wavenumber / self.spacing).round() as usize;
        let from = place.saturating_sub(OVERSAMPLING).checked_sub(self.first)?;
        let part = powers.get(from..=from + 2 * OVERSAMPLING)?;
        Some(part.iter().copied().fold(0.0, f64::max))
    }

    /// Variance of the noise around a wavenumber, mNm².
    pub(crate) fn background(&self, powers: &[f64], wavenumber: f64) -> f64 {
        let resolution = self.resolution();
        let range = wavenumber / 3.0..(3.0 * wavenumber).max(wavenumber + 8.0 * resolution);
        let mut near: Vec<f64> = powers
            .iter()
            .enumerate()
            .map(|(index, power)| ((index + self.first) as f64 * self.spacing, *power))
            .filter(|(k, _)| range.contains(k) && (k - wavenumber).abs() > resolution)
            .map(|(_, power)| power)
            .collect();
        noise_variance(&mut near)
    }

    /// Second highest peak of the `powers` away from the `wavenumber` of a detent and from two and three times it, mNm².
    ///
    /// Counts only periods of which the travel holds at least `fewest`.
    pub(crate) fn null_test(&self, powers: &[f64], wavenumber: f64, fewest: f64) -> f64 {
        let resolution = self.resolution();
        let mut others = self.peaks(powers, 64).into_iter().filter(|peak| {
            let multiple = (peak.wavenumber / wavenumber).round().clamp(1.0, 3.0);
            (peak.wavenumber - multiple * wavenumber).abs() > resolution && peak.wavenumber >= fewest * resolution
        });
        let Some(strongest) = others.next() else { return 0.0 };
        others.find(|peak| (peak.wavenumber - strongest.wavenumber).abs() > resolution).map_or(0.0, |peak| peak.power)
    }

    /// Mean square gain of the rows' filter for a detent of each wavenumber, over the speeds of the capture: summed at every few
    /// wavenumbers, on straight lines between those.
    fn attenuations(&self, row_filter: &RowFilter, band: &Band, speeds: &[f64]) -> Vec<f64> {
        const BINS: usize = 64;
        let fastest = speeds.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let mut counts = vec![0.0; BINS];
        for speed in speeds {
            counts[((speed / fastest * BINS as f64) as usize).min(BINS - 1)] += 1.0;
        }
        let total: f64 = counts.iter().sum();
        let table_hz = 3.0 * band.edge_hz / 256.0;
        let table: Vec<f64> =
            (0..=256).map(|i| row_filter.fir.gain(f64::from(i) * table_hz, row_filter.rate_hz).powi(2)).collect();
        let middles: Vec<f64> = (0..BINS).map(|bin| (bin as f64 + 0.5) / BINS as f64 * fastest / TAU).collect();
        let gain = |index: f64| {
            let wavenumber = index * self.spacing;
            let gains: Vec<f64> = middles
                .iter()
                .map(|turns| table.get((wavenumber * turns / table_hz).round() as usize).copied().unwrap_or(0.0))
                .collect();
            dot(&gains, &counts) / total
        };
        let mut attenuations = Vec::with_capacity(self.last + 1 - self.first);
        let (mut left, mut right) = (self.first as f64, self.first as f64);
        let (mut at_left, mut at_right) = (gain(left), gain(right));
        for index in self.first..=self.last {
            if index as f64 > right {
                (left, at_left) = (right, at_right);
                right = (GAIN_STEP * left).floor().max(left + 1.0);
                at_right = gain(right);
            }
            let share = if right > left { (index as f64 - left) / (right - left) } else { 0.0 };
            attenuations.push(at_left + share * (at_right - at_left));
        }
        attenuations
    }
}
