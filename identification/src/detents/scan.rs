//! The period of detents, searched over everything that the travel supports, without a starting point.
//!
//! For every wavenumber k = 1/P, how much of the base model's residual r would a·sin(kθ) + b·cos(kθ) take
//! away? The rows' filter F moves to the other side of each inner product, ⟨r, F·e^{ikθ}⟩ = ⟨Fᵀr, e^{ikθ}⟩,
//! and Σ uₙ·e^{ikθₙ} for all k at once is one Fourier transform of u gathered by angle. The cost is
//! that of a few transforms whatever the number of periods tried.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::DMatrix;
use realfft::{RealToComplex, num_complex::Complex};

use crate::numerics::fourier;
use crate::numerics::vector::{self, dot};
use crate::preparation::motion::Band;
use crate::preparation::row_filter::RowFilter;
use crate::regression::problem::Problem;
use crate::uncertainty::statistics::{median, quantile};

/// Fewest periods that the travel must hold for a period to be estimated.
pub(crate) const FEWEST_PERIODS: f64 = 1.25;
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
/// Share of a sinusoid's square that is added to it twice over, so that one that the base columns nearly explain is not estimated
/// from rounding.
const RIDGE: f64 = 3e-3;
/// Share of the samples that must see a detent slowly enough for the band.
const SLOW_SHARE: f64 = 0.1;

/// A period that stands out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    /// Wavenumber 1/P, 1/rad.
    pub(crate) wavenumber: f64,
    /// Sum of squares that a detent of this period takes away, mNm².
    pub(crate) power: f64,
}

/// All that the scan needs of motion and base columns, gathered once.
pub(crate) struct Scan {
    travel_rad: f64,
    /// Distance of two wavenumbers, 1/rad.
    spacing: f64,
    first: usize,
    last: usize,
    fine: Gather,
    /// [`gram_inverse`] for every wavenumber.
    inverses: Vec<[f64; 3]>,
}

impl Scan {
    /// `inverse` is the inverse of the Gram matrix of the base problem's columns. `None` if the travel supports no period at all.
    pub(crate) fn new(base: &Problem<'_>, inverse: &DMatrix<f64>, band: &Band, angle_step_rad: f64) -> Option<Self> {
        let Problem { row_filter, motion, columns, .. } = base;
        let (offset_rad, _) = vector::extent(&motion.angle_rad)?;
        let (lowest, highest) = vector::extent_where(&motion.angle_rad, &row_filter.mask)?;
        let travel_rad = highest - lowest;
        let at_rows = || (0..motion.len()).step_by(row_filter.step);
        let mut speeds: Vec<f64> = at_rows()
            .filter(|index| row_filter.mask[*index] > 0.0)
            .map(|index| motion.velocity_rad_s[index].abs())
            .collect();
        let slow_rad_s = quantile(&mut speeds, SLOW_SHARE);
        let spacing = TAU / (OVERSAMPLING * travel_rad);
        let highest = (TAU * band.edge_hz / slow_rad_s).min(FRAC_PI_2 / angle_step_rad.max(f64::MIN_POSITIVE));
        let last = (highest / spacing).min(LARGEST_TRANSFORM as f64 / BINS_PER_PERIOD) as usize;
        let first = (OVERSAMPLING * FEWEST_PERIODS).ceil() as usize;
        if !(travel_rad > 0.0 && last > first) {
            return None;
        }
        // The transform spans OVERSAMPLING × the travel; the full angle range may be a little wider than the sliding one.
        let length = ((BINS_PER_PERIOD * last as f64) as usize).next_power_of_two().clamp(1024, LARGEST_TRANSFORM);
        let base_last = last.min(MOST_BASE);
        let coarse_length = ((2.0 * BINS_PER_PERIOD * base_last as f64) as usize).next_power_of_two();
        let coarse = Gather::new(coarse_length, offset_rad, spacing, 2 * base_last);
        // A base column varies slowly, and low wavenumbers pass the rows' filter: rows alone will do.
        let angles: Vec<f64> = at_rows().map(|index| motion.angle_rad[index]).collect();
        let masks: Vec<f64> = at_rows().map(|index| row_filter.mask[index]).collect();
        let columns: Vec<&[f64]> = columns.iter().map(|rows| &**rows).chain([&masks[..]]).collect();
        let mut base = coarse.sums_of(&columns, &angles);
        let weights = base.pop()?;
        let mut scan = Self {
            travel_rad,
            spacing,
            first,
            last,
            fine: Gather::new(length, offset_rad, spacing, last),
            inverses: Vec::new(),
        };
        let attenuations = scan.attenuations(row_filter, band, &speeds);
        scan.inverses =
            (first..).zip(&attenuations).map(|(k, gain)| gram_inverse(k, *gain, &base, &weights, inverse)).collect();
        Some(scan)
    }

    /// Longest and shortest period P that is searched, rad.
    pub(crate) fn periods_rad(&self) -> (f64, f64) {
        (1.0 / (self.first as f64 * self.spacing), 1.0 / (self.last as f64 * self.spacing))
    }

    /// Number of independent periods among those tried.
    pub(crate) fn independent(&self) -> f64 {
        ((self.last - self.first) as f64 / OVERSAMPLING).max(1.0)
    }

    /// Width of a peak, 1/rad.
    pub(crate) fn resolution(&self) -> f64 {
        TAU / self.travel_rad
    }

    /// What a detent at each wavenumber would take off the residual's sum of squares, mNm².
    pub(crate) fn powers(&self, base: &Problem<'_>, residual: &[f64]) -> Vec<f64> {
        let target = self.fine.sums(&base.row_filter.spread(residual), &base.motion.angle_rad);
        let found = target.get(self.first..).unwrap_or_default().iter().zip(&self.inverses);
        found.map(|(sum, inverse)| power(inverse, *sum)).collect()
    }

    /// The strongest peaks, at least a peak's width apart, strongest first.
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
                let top = vertex_of(powers, index);
                Peak { wavenumber: ((index + self.first) as f64 + top) * self.spacing, power: powers[index] }
            })
            .collect()
    }

    /// Largest power within a peak's width of a wavenumber, mNm²; `None` beyond what was searched.
    pub(crate) fn near(&self, powers: &[f64], wavenumber: f64) -> Option<f64> {
        let place = (wavenumber / self.spacing).round() as usize;
        let from = place.saturating_sub(OVERSAMPLING as usize).checked_sub(self.first)?;
        let part = powers.get(from..=from + 2 * OVERSAMPLING as usize)?;
        Some(part.iter().copied().fold(0.0, f64::max))
    }

    /// Typical power of what is no detent around a wavenumber: the median of the neighbourhood, mNm².
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
        background_of(&mut near)
    }

    /// Power of the second strongest period in what a detent of `wavenumber` left, multiples of it apart, mNm².
    ///
    /// Only periods are counted of which the travel holds at least `fewest`.
    pub(crate) fn null_test(&self, left: &[f64], wavenumber: f64, fewest: f64) -> f64 {
        let resolution = self.resolution();
        let mut others = self.peaks(left, 64).into_iter().filter(|peak| {
            let multiple = (peak.wavenumber / wavenumber).round().clamp(1.0, 3.0);
            (peak.wavenumber - multiple * wavenumber).abs() > resolution && peak.wavenumber >= fewest * resolution
        });
        let Some(strongest) = others.next() else { return 0.0 };
        others.find(|peak| (peak.wavenumber - strongest.wavenumber).abs() > resolution).map_or(0.0, |peak| peak.power)
    }

    /// Mean square gain of the rows' filter for a detent, over the speeds of the capture.
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

/// What a sinusoid takes off a sum of squares, from an entry of [`Scan::inverses`] and the residual's Fourier sum.
pub(crate) fn power([sine, both, cosine]: &[f64; 3], residual: Complex<f64>) -> f64 {
    sine * residual.im * residual.im + both * residual.im * residual.re + cosine * residual.re * residual.re
}

/// The variance of noise from powers of which most are of noise: two squared normal numbers have the median 2·ln 2 in units of it.
pub(crate) fn background_of(powers: &mut [f64]) -> f64 {
    median(powers) / (2.0 * 2_f64.ln())
}

/// Where a parabola through a peak and its neighbours has its top, in steps from the peak.
pub(crate) fn vertex_of(powers: &[f64], peak: usize) -> f64 {
    let neighbours = peak.checked_sub(1).and_then(|left| Some((powers[left], *powers.get(peak + 1)?)));
    let Some((left, right)) = neighbours else { return 0.0 };
    let bend = 2.0 * powers[peak] - left - right;
    if bend > 0.0 { (0.5 * (right - left) / bend).clamp(-0.5, 0.5) } else { 0.0 }
}

/// The inverse of the Gram matrix of sine and cosine beside the base columns, for the wavenumber of an `index` at which the rows' filter
/// has the mean square gain `attenuation`: the factors of sine², of sine times cosine (that of both off-diagonal entries) and of cosine².
/// Zeros where the base columns explain a sinusoid as well.
///
/// `base` and `weights` are Fourier sums of the base columns and of the mask, `inverse` is that of the base columns' Gram matrix.
pub(crate) fn gram_inverse(
    index: usize,
    attenuation: f64,
    base: &[Vec<Complex<f64>>],
    weights: &[Complex<f64>],
    inverse: &DMatrix<f64>,
) -> [f64; 3] {
    let diagonal = 0.5 * weights[0].re * attenuation * (1.0 + 2.0 * RIDGE);
    let mut gram = [diagonal, 0.0, diagonal];
    if let Some(at_twice) = weights.get(2 * index) {
        // sin² = (1 − cos 2x)/2, sin·cos = sin 2x/2, cos² = (1 + cos 2x)/2.
        let half = 0.5 * attenuation * at_twice;
        gram = [diagonal - half.re, half.im, diagonal + half.re];
        // The part that the base columns explain is taken off.
        for (column, left) in base.iter().enumerate() {
            let left = left[index];
            let right: Complex<f64> =
                base.iter().zip(inverse.column(column).iter()).map(|(b, share)| b[index] * share).sum();
            gram[0] -= left.im * right.im;
            gram[1] -= left.im * right.re;
            gram[2] -= left.re * right.re;
        }
    }
    let determinant = gram[0] * gram[2] - gram[1] * gram[1];
    if gram[0] <= 0.0 || determinant <= 0.0 {
        return [0.0; 3];
    }
    [gram[2] / determinant, -2.0 * gram[1] / determinant, gram[0] / determinant]
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
