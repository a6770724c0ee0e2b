//! Torque and base columns gathered by angle: the detent scan of a stream that is not kept.

use std::f64::consts::TAU;

use realfft::num_complex::Complex;

use crate::detents::{Wavenumbers, inverse_beside, power};
use crate::regression::Gram;
use crate::vector::fourier;

/// Most bins; when the travel outgrows them, neighbours merge.
const MOST_BINS: usize = 8192;
/// Width of the first bins, rad.
const FIRST_WIDTH_RAD: f64 = 1e-6;
/// Wavenumbers tried per width of a peak, at least.
const OVERSAMPLING: usize = 4;
/// Angle bins per period of the finest detent searched.
const BINS_PER_PERIOD: f64 = 20.0;
/// How far the best period must stand above the background: further than in a fit of a whole capture, since nothing is held out, …
const MARGIN: f64 = 14.0;
/// … and the share of the residual that it must explain, or its amplitude relative to the torque's RMS.
const WORTHWHILE_SHARE: f64 = 0.25;
const WORTHWHILE_AMPLITUDE: f64 = 0.1;

/// Sums of unfiltered columns and torque by angle.
#[derive(Debug)]
pub(super) struct AngleBins {
    width: usize,
    bin_rad: f64,
    /// Angle of the first bin's lower edge, in bins.
    first: i64,
    /// Per bin: number of samples, then sums of torque and columns.
    sums: Vec<f64>,
    bins: usize,
    /// Inner products of torque and columns.
    gram: Gram,
}

/// The best period of a scan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scan {
    pub(super) wavenumber: f64,
    pub(super) travel_rad: f64,
    /// Whether the evidence says that there are detents.
    pub(super) detents: bool,
}

impl AngleBins {
    /// For rows of the torque and so many columns.
    pub(super) fn new(columns: usize) -> Self {
        Self {
            width: columns + 1,
            bin_rad: FIRST_WIDTH_RAD,
            first: 0,
            sums: Vec::new(),
            bins: 0,
            gram: Gram::empty(columns),
        }
    }

    /// Distance between the outermost angles, rad.
    pub(super) fn travel_rad(&self) -> f64 {
        self.bins as f64 * self.bin_rad
    }

    /// Middle of the travel, rad.
    pub(super) fn middle_rad(&self) -> f64 {
        (self.first as f64 + 0.5 * self.bins as f64) * self.bin_rad
    }

    /// Adds a sample.
    pub(super) fn add(&mut self, angle_rad: f64, row: &[f64]) {
        self.gram.add_row(row);
        self.make_room(angle_rad);
        // Shared between the two nearest bin middles, so that a bin's width hardly shows.
        let place = angle_rad / self.bin_rad - 0.5 - self.first as f64;
        let lower = place.floor();
        let share = place - lower;
        for (bin, weight) in [(lower as i64, 1.0 - share), (lower as i64 + 1, share)] {
            let bin = bin.clamp(0, self.bins as i64 - 1) as usize;
            let sums = &mut self.sums[bin * (self.width + 1)..(bin + 1) * (self.width + 1)];
            sums[0] += weight;
            sums[1..].iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
        }
    }

    fn make_room(&mut self, angle_rad: f64) {
        let stride = self.width + 1;
        loop {
            let bin = (angle_rad / self.bin_rad).floor() as i64;
            if self.bins == 0 {
                self.first = bin;
                self.bins = 1;
                self.sums = vec![0.0; stride];
                return;
            }
            let (low, high) = (bin.min(self.first), bin.max(self.first + self.bins as i64 - 1));
            if high - low >= MOST_BINS as i64 {
                self.coarsen();
                continue;
            }
            if low < self.first {
                let more = (self.first - low) as usize * stride;
                self.sums.splice(0..0, std::iter::repeat_n(0.0, more));
                self.first = low;
            }
            self.bins = (high - low + 1) as usize;
            self.sums.resize(self.bins * stride, 0.0);
            return;
        }
    }

    fn coarsen(&mut self) {
        let stride = self.width + 1;
        let first = self.first.div_euclid(2);
        let bins = ((self.first + self.bins as i64 - 1).div_euclid(2) - first + 1) as usize;
        let mut sums = vec![0.0; bins * stride];
        for bin in 0..self.bins {
            let target = ((self.first + bin as i64).div_euclid(2) - first) as usize;
            for index in 0..stride {
                sums[target * stride + index] += self.sums[bin * stride + index];
            }
        }
        self.sums = sums;
        self.first = first;
        self.bins = bins;
        self.bin_rad *= 2.0;
    }

    /// The best period, given the base coefficients; `None` while the travel supports none.
    pub(super) fn scan(&self, coefficients: &[f64], slow_rad_s: f64, band_hz: f64) -> Option<Scan> {
        let length = (OVERSAMPLING * self.bins).next_power_of_two();
        let spacing = TAU / (length as f64 * self.bin_rad);
        let travel_rad = self.travel_rad();
        let finest = (TAU / (BINS_PER_PERIOD * self.bin_rad)).min(TAU * band_hz / slow_rad_s);
        let last = ((finest / spacing) as usize).min(length / 4 - 1);
        let wavenumbers = Wavenumbers::of(travel_rad, spacing, last)?;
        if last <= wavenumbers.first + 2 * OVERSAMPLING {
            return None;
        }
        let inverse = self.gram.solve().inverse;
        let spectra = self.spectra(length, 2 * last + 1);
        let (weights, torque, base) = (&spectra[0], &spectra[1], &spectra[2..]);
        let powers: Vec<f64> = (wavenumbers.first..=last)
            .map(|index| {
                let explained: Complex<f64> = base.iter().zip(coefficients).map(|(column, c)| column[index] * c).sum();
                power(torque[index] - explained, inverse_beside(index, 1.0, base, weights, &inverse))
            })
            .collect();
        let best = *wavenumbers.peaks(&powers, 1).first()?;
        let background = wavenumbers.background(&powers, best.wavenumber);
        let samples = weights[0].re;
        let amplitude = (2.0 * best.power / samples).sqrt();
        let clear = best.power > wavenumbers.needed(MARGIN) * background;
        let worthwhile = best.power > WORTHWHILE_SHARE * self.gram.left(coefficients)
            || amplitude > WORTHWHILE_AMPLITUDE * (self.gram.total() / samples).sqrt();
        Some(Scan { wavenumber: best.wavenumber, travel_rad, detents: clear && worthwhile })
    }

    /// Σ value·exp(ikθ) for the counts, the torque and every column, θ from the middle of the first bin: the `count` longest
    /// waves.
    fn spectra(&self, length: usize, count: usize) -> Vec<Vec<Complex<f64>>> {
        let stride = self.width + 1;
        let transform = fourier::forward(length);
        let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
        let spectrum = |column: usize| {
            input.fill(0.0);
            let sums = self.sums.chunks_exact(stride).map(|sums| sums[column]);
            input.iter_mut().zip(sums).for_each(|(slot, sum)| *slot = sum);
            if transform.process(&mut input, &mut output).is_err() {
                output.fill(Complex::ZERO);
            }
            output[..count].iter().map(Complex::conj).collect()
        };
        (0..stride).map(spectrum).collect()
    }
}
