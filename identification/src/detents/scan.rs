//! The period of detents, searched over everything that the travel supports, without a starting point.
//!
//! For every wavenumber k = 1/P, how much of the base model's residual r would a·sin(kθ) + b·cos(kθ) take
//! away? The rows' filter F moves to the other side of each inner product, ⟨r, F·e^{ikθ}⟩ = ⟨Fᵀr, e^{ikθ}⟩,
//! and Σ uₙ·e^{ikθₙ} for all k at once is one Fourier transform of u gathered by angle. The cost is
//! that of a few transforms whatever the number of periods tried.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::DMatrix;
use realfft::{RealToComplex, num_complex::Complex};

use super::wavenumbers::{Wavenumbers, inverse_beside, power};
use crate::preparation::{Band, KnobMotion, RowMask};
use crate::regression::Column;
use crate::statistics::quantile;
use crate::vector::{self, dot, fourier};

/// Wavenumbers tried per width of a peak.
const OVERSAMPLING: f64 = 4.0;
/// Largest transform.
const LARGEST_TRANSFORM: usize = 1 << 15;
/// Angle bins per period of the finest detent: cubic splines between them are then right to 0.3 %.
const BINS_PER_PERIOD: f64 = 5.2;
/// Base columns are looked at up to this index of a wavenumber, 128 periods in the travel: finer sinusoids have hardly
/// anything in common with them (less than a percent, from the turning points of the sweep).
const MOST_BASE: usize = 512;
/// Wavenumbers at which the filter's gain is summed over the speeds lie this factor apart.
const GAIN_STEP: f64 = 1.03;
/// Share of the samples that must see a detent slowly enough for the band.
const SLOW_SHARE: f64 = 0.1;

/// All that the scan needs of motion and base columns, gathered once.
pub(crate) struct Scan {
    pub(crate) wavenumbers: Wavenumbers,
    fine: Gather,
    /// [`inverse_beside`] the base columns for every wavenumber.
    inverses: Vec<[f64; 3]>,
}

impl Scan {
    /// `base_rows` are the base columns as rows, `inverse` the inverse of their Gram matrix. `None` if
    /// the travel supports no period at all.
    pub(crate) fn new(
        row_mask: &RowMask,
        motion: &KnobMotion,
        band: &Band,
        angle_step_rad: f64,
        base_rows: &[Column],
        inverse: &DMatrix<f64>,
    ) -> Option<Self> {
        let (offset_rad, _) = vector::extent(&motion.angle_rad)?;
        let (lowest, highest) = vector::extent_where(&motion.angle_rad, &row_mask.mask)?;
        let travel_rad = highest - lowest;
        let at_rows = || (0..motion.len()).step_by(row_mask.step);
        let mut speeds: Vec<f64> = at_rows()
            .filter(|index| row_mask.mask[*index] > 0.0)
            .map(|index| motion.velocity_rad_s[index].abs())
            .collect();
        let slow_rad_s = quantile(&mut speeds, SLOW_SHARE);
        let spacing = TAU / (OVERSAMPLING * travel_rad);
        let highest = (TAU * band.edge_hz / slow_rad_s).min(FRAC_PI_2 / angle_step_rad.max(f64::MIN_POSITIVE));
        let last = (highest / spacing).min(LARGEST_TRANSFORM as f64 / BINS_PER_PERIOD) as usize;
        let wavenumbers = Wavenumbers::of(travel_rad, spacing, last)?;
        // The transform spans OVERSAMPLING × the travel; the full angle range may be a little wider than the sliding one.
        let length = ((BINS_PER_PERIOD * last as f64) as usize).next_power_of_two().clamp(1024, LARGEST_TRANSFORM);
        let base_last = last.min(MOST_BASE);
        let coarse_length = ((2.0 * BINS_PER_PERIOD * base_last as f64) as usize).next_power_of_two();
        let coarse = Gather::new(coarse_length, offset_rad, spacing, 2 * base_last);
        // A base column varies slowly, and low wavenumbers pass the rows' filter: rows alone will do.
        let angles: Vec<f64> = at_rows().map(|index| motion.angle_rad[index]).collect();
        let masks: Vec<f64> = at_rows().map(|index| row_mask.mask[index]).collect();
        let mut columns: Vec<&[f64]> = base_rows.iter().map(|rows| &**rows).collect();
        columns.push(&masks);
        let mut base = coarse.sums_of(&columns, &angles);
        let weights = base.pop()?;
        let attenuations = attenuations(&wavenumbers, row_mask, band, &speeds);
        let inverses = (wavenumbers.first..).zip(&attenuations);
        let inverses = inverses.map(|(k, gain)| inverse_beside(k, *gain, &base, &weights, inverse)).collect();
        Some(Self { wavenumbers, fine: Gather::new(length, offset_rad, spacing, last), inverses })
    }

    /// What a detent at each wavenumber would take off the residual's sum of squares, mNm².
    pub(crate) fn powers(&self, row_mask: &RowMask, motion: &KnobMotion, residual: &[f64]) -> Vec<f64> {
        let target = self.fine.sums(&row_mask.spread(residual), &motion.angle_rad);
        let found = target.get(self.wavenumbers.first..).unwrap_or_default().iter().zip(&self.inverses);
        found.map(|(sum, inverse)| power(*sum, *inverse)).collect()
    }
}

/// Mean square gain of the rows' filter for a detent, over the speeds of the capture.
fn attenuations(wavenumbers: &Wavenumbers, row_mask: &RowMask, band: &Band, speeds: &[f64]) -> Vec<f64> {
    const BINS: usize = 64;
    let fastest = speeds.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let mut counts = vec![0.0; BINS];
    for speed in speeds {
        counts[((speed / fastest * BINS as f64) as usize).min(BINS - 1)] += 1.0;
    }
    let total: f64 = counts.iter().sum();
    let table_hz = 3.0 * band.edge_hz / 256.0;
    let table: Vec<f64> =
        (0..=256).map(|i| row_mask.fir.gain(f64::from(i) * table_hz, row_mask.rate_hz).powi(2)).collect();
    let middles: Vec<f64> = (0..BINS).map(|bin| (bin as f64 + 0.5) / BINS as f64 * fastest / TAU).collect();
    let gain = |index: f64| {
        let wavenumber = index * wavenumbers.spacing;
        let gains: Vec<f64> = middles
            .iter()
            .map(|turns| table.get((wavenumber * turns / table_hz).round() as usize).copied().unwrap_or(0.0))
            .collect();
        dot(&gains, &counts) / total
    };
    let mut attenuations = Vec::with_capacity(wavenumbers.last + 1 - wavenumbers.first);
    let (mut left, mut right) = (wavenumbers.first as f64, wavenumbers.first as f64);
    let (mut at_left, mut at_right) = (gain(left), gain(right));
    for index in wavenumbers.first..=wavenumbers.last {
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

/// Fourier sums over samples at uneven angles.
struct Gather {
    offset_rad: f64,
    bin_rad: f64,
    /// What undoes the spline and its shift, for every wavenumber up to the last.
    correction: Vec<Complex<f64>>,
    transform: std::sync::Arc<dyn RealToComplex<f64>>,
}

impl Gather {
    /// Sums for k = 0, 1, …, `last` times the `spacing` by a transform of `length` bins, a power of two.
    fn new(length: usize, offset_rad: f64, spacing: f64, last: usize) -> Self {
        let half = 0.5 * TAU / length as f64;
        let indices: Vec<f64> = (0..=last).map(|index| index as f64).collect();
        let (mut sines, mut cosines) = (vec![0.0; indices.len()], vec![0.0; indices.len()]);
        vector::sines(&indices, half, &mut sines, &mut cosines);
        let correction = indices.iter().zip(sines.iter().zip(&cosines)).map(|(index, (sine, cosine))| {
            // The bins lie one too late, and the spline's own transform is the fourth power of a sinc.
            let sinc = if *index == 0.0 { 1.0 } else { sine / (half * index) };
            let square = sinc * sinc;
            Complex::new(cosine * cosine - sine * sine, -2.0 * sine * cosine) / (square * square)
        });
        let correction = correction.collect();
        let bin_rad = TAU / (spacing * length as f64);
        Self { offset_rad, bin_rad, correction, transform: fourier::forward(length) }
    }

    /// Σ uₙ·exp(ikθₙ) for all k.
    ///
    /// Every value is shared out among four bins by a cubic spline, whose own transform is divided out again.
    fn sums(&self, values: &[f64], angles: &[f64]) -> Vec<Complex<f64>> {
        let mut bins = self.transform.make_input_vec();
        // What is masked counts as zero, so it does not matter where angles beyond the sliding ones end up.
        vector::share_out(values, angles, self.offset_rad, self.bin_rad, &mut bins);
        self.transformed(&mut bins)
    }

    /// [`Self::sums`] of several columns with the same angles.
    fn sums_of(&self, columns: &[&[f64]], angles: &[f64]) -> Vec<Vec<Complex<f64>>> {
        /// Columns that are shared out together.
        const TOGETHER: usize = 8;
        let empty = vec![0.0; angles.len()];
        let mut bins = self.transform.make_input_vec();
        let mut sums = Vec::with_capacity(columns.len());
        for part in columns.chunks(TOGETHER) {
            let together: [&[f64]; TOGETHER] = std::array::from_fn(|lane| part.get(lane).copied().unwrap_or(&empty));
            let mut shared = vec![[0.0; TOGETHER]; bins.len()];
            vector::share_out_together(&together, angles, self.offset_rad, self.bin_rad, &mut shared);
            for lane in 0..part.len() {
                bins.iter_mut().zip(&shared).for_each(|(bin, shared)| *bin = shared[lane]);
                sums.push(self.transformed(&mut bins));
            }
        }
        sums
    }

    /// The sums from the shares in the bins, which are overwritten.
    fn transformed(&self, bins: &mut [f64]) -> Vec<Complex<f64>> {
        let mut sums = self.transform.make_output_vec();
        if self.transform.process(bins, &mut sums).is_err() {
            sums.fill(Complex::new(0.0, 0.0));
        }
        // The transform has the other sign in the exponent.
        sums.iter().zip(&self.correction).map(|(sum, correction)| sum.conj() * correction).collect()
    }
}
