//! Torque and base columns summed by angle: the search for detents in a stream whose samples are not kept.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVectorView};
use realfft::num_complex::Complex;

use super::{WORTHWHILE_AMPLITUDE, WORTHWHILE_SHARE};
use crate::numerics::fourier;
use crate::regression::gram::{self, COLLINEAR};
use crate::sinusoids::reduction::Reduction;
use crate::sinusoids::{FEWEST_PERIODS, OVERSAMPLING, noise_variance, threshold, vertex};

/// Most columns of a row, torque included.
pub(crate) const MOST_COLUMNS: usize = 16;
/// Most bins; when the travel outgrows them, neighbours merge.
const MOST_BINS: usize = 8192;
/// Width of the first bins, rad.
const FIRST_WIDTH_RAD: f64 = 1e-6;
/// Angle bins per period of the finest detent searched.
const BINS_PER_PERIOD: f64 = 20.0;
/// Margin of the best period, wider than that of a whole capture: the scan is repeated as the data grow.
const MARGIN: f64 = 14.0;

/// Sums of unfiltered base columns and torque in bins of angle.
#[derive(Debug)]
pub(crate) struct AngleBins {
    bin_rad: f64,
    /// Angle of the first bin's lower edge, in bins.
    first: i64,
    /// Per bin: number of samples, then the columns' sums.
    sums: VecDeque<[f64; MOST_COLUMNS]>,
    /// Inner products of the rows' columns.
    gram: DMatrix<f64>,
}

/// The best period of a scan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scan {
    pub(crate) wavenumber: f64,
    pub(crate) travel_rad: f64,
    /// Whether the evidence says that there are detents.
    pub(crate) detents: bool,
}

impl AngleBins {
    /// For rows of `width` columns, the first of them the torque.
    pub(crate) fn new(width: usize) -> Self {
        Self { bin_rad: FIRST_WIDTH_RAD, first: 0, sums: VecDeque::new(), gram: DMatrix::zeros(width, width) }
    }

    /// Distance between the outermost angles, rad.
    pub(crate) fn travel_rad(&self) -> f64 {
        self.sums.len() as f64 * self.bin_rad
    }

    /// Middle of the travel, rad.
    pub(crate) fn middle_rad(&self) -> f64 {
        (self.first as f64 + 0.5 * self.sums.len() as f64) * self.bin_rad
    }

    pub(crate) fn add(&mut self, angle_rad: f64, row: &[f64]) {
        let columns = DVectorView::from_slice(row, row.len());
        self.gram.ger(1.0, &columns, &columns, 1.0);
        self.make_room(angle_rad);
        // Each sample is shared between the two nearest bin middles, so that the bins' width has little effect.
        let place = angle_rad / self.bin_rad - 0.5 - self.first as f64;
        let lower = place.floor();
        let share = place - lower;
        for (bin, weight) in [(lower as i64, 1.0 - share), (lower as i64 + 1, share)] {
            let bin = bin.clamp(0, self.sums.len() as i64 - 1) as usize;
            let sums = &mut self.sums[bin];
            sums[0] += weight;
            sums[1..].iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
    }

    /// Adds bins up to an angle, and merges neighbours until they are few enough.
    fn make_room(&mut self, angle_rad: f64) {
        loop {
            let bin = (angle_rad / self.bin_rad).floor() as i64;
            if self.sums.is_empty() {
                self.first = bin;
            }
            let last = self.first + self.sums.len() as i64 - 1;
            let (low, high) = (bin.min(self.first), bin.max(last));
            if high - low < MOST_BINS as i64 {
                (low..self.first).for_each(|_| self.sums.push_front([0.0; MOST_COLUMNS]));
                self.first = low;
                self.sums.resize((high - low + 1) as usize, [0.0; MOST_COLUMNS]);
                return;
            }
            self.coarsen();
        }
    }

    /// Merges bins pairwise.
    fn coarsen(&mut self) {
        let first = self.first.div_euclid(2);
        let mut coarse = VecDeque::new();
        for (bin, sums) in (self.first..).zip(&self.sums) {
            coarse.resize((bin.div_euclid(2) - first + 1) as usize, [0.0; MOST_COLUMNS]);
            if let Some(coarse) = coarse.back_mut() {
                coarse.iter_mut().zip(sums).for_each(|(sum, value)| *sum += value);
            }
        }
        (self.first, self.sums) = (first, coarse);
        self.bin_rad *= 2.0;
    }

    /// The best period, given the base coefficients; `None` while the travel supports none, or the columns cannot be solved for.
    pub(crate) fn scan(&self, coefficients: &[f64], slow_rad_s: f64, band_hz: f64) -> Option<Scan> {
        let columns = self.gram.nrows() - 1;
        let length = (OVERSAMPLING * self.sums.len()).next_power_of_two();
        let spacing = TAU / (length as f64 * self.bin_rad);
        let travel_rad = self.travel_rad();
        let first = (FEWEST_PERIODS * TAU / travel_rad / spacing).ceil() as usize;
        let finest = (TAU / (BINS_PER_PERIOD * self.bin_rad)).min(TAU * band_hz / slow_rad_s);
        let last = ((finest / spacing) as usize).min(length / 4 - 1);
        if last <= first + 2 * OVERSAMPLING {
            return None;
        }
        let all: Vec<usize> = (0..columns).collect();
        let inverse = gram::solve(&self.gram, &all, COLLINEAR)?.inverse();
        let mut spectra = self.spectra(length, 2 * last + 1);
        let (weights, mut residual) = (spectra.remove(0), spectra.remove(0));
        for (column, coefficient) in spectra.iter().zip(coefficients) {
            residual.iter_mut().zip(column).for_each(|(left, line)| *left -= line * coefficient);
        }
        let power = |index| Reduction::new(index, 1.0, &spectra, &weights, &inverse).of(residual[index]);
        let powers: Vec<f64> = (first..=last).map(power).collect();
        let best = (0..powers.len()).max_by(|a, b| powers[*a].total_cmp(&powers[*b]))?;
        let wavenumber = (first + best) as f64 * spacing + spacing * vertex(&powers, best);
        let peak = TAU / travel_rad / spacing;
        let mut elsewhere: Vec<f64> = powers
            .iter()
            .enumerate()
            .filter(|(index, _)| (*index as f64 - best as f64).abs() > peak)
            .map(|(_, power)| *power)
            .collect();
        let noise = noise_variance(&mut elsewhere);
        let total = gram::squares_left(&self.gram, coefficients).max(0.0);
        let torque_square = self.gram[(0, 0)];
        let samples = weights[0].re;
        let amplitude = (2.0 * powers[best] / samples).sqrt();
        let clear = powers[best] > threshold(powers.len() as f64 / peak, MARGIN) * noise;
        let worthwhile = powers[best] > WORTHWHILE_SHARE * total
            || amplitude > WORTHWHILE_AMPLITUDE * (torque_square / samples).sqrt();
        Some(Scan { wavenumber, travel_rad, detents: clear && worthwhile })
    }

    /// Σ value·exp(ikθ) for the counts and every column, θ from the middle of the first bin: the `count` longest waves.
    fn spectra(&self, length: usize, count: usize) -> Vec<Vec<Complex<f64>>> {
        let transform = fourier::forward(length);
        let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
        let spectrum = |column| {
            input.fill(0.0);
            input.iter_mut().zip(&self.sums).for_each(|(slot, sums): (_, &[f64; MOST_COLUMNS])| *slot = sums[column]);
            if transform.process(&mut input, &mut output).is_err() {
                output.fill(Complex::ZERO);
            }
            // The exponent of the transform is negative, that of these sums positive.
            output[..count].iter().map(Complex::conj).collect()
        };
        (0..=self.gram.nrows()).map(spectrum).collect()
    }
}
