//! The period of detents, searched over everything that the travel supports, without a starting point.
//!
//! For every wavenumber k = 1/P, how much of the base model's residual r would a·sin(kθ) + b·cos(kθ) take
//! away? The rows' filter F moves to the other side of each inner product, ⟨r, F·e^{ikθ}⟩ = ⟨Fᵀr, e^{ikθ}⟩,
//! and Σ uₙ·e^{ikθₙ} for all k at once is one Fourier transform of u gathered by angle. The cost is
//! that of a few transforms whatever the number of periods tried.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::{DMatrix, Matrix2, Vector2};
use realfft::{RealFftPlanner, RealToComplex, num_complex::Complex};

use crate::frame::Frame;
use crate::least_squares::dot;
use crate::motion::{Band, KnobMotion};
use crate::problem::Column;
use crate::samples::span;
use crate::spectrum::{median, quantile};

/// Fewest periods that the travel must hold for a period to be told.
pub(crate) const FEWEST_PERIODS: f64 = 1.25;
/// Wavenumbers tried per width of a peak.
const OVERSAMPLING: f64 = 4.0;
/// Largest transform.
const LARGEST_TRANSFORM: usize = 1 << 17;
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
    offset_rad: f64,
    bin_rad: f64,
    length: usize,
    transform: std::sync::Arc<dyn RealToComplex<f64>>,
    base: Vec<Vec<Complex<f64>>>,
    weights: Vec<Complex<f64>>,
    attenuation: Vec<f64>,
    inverse: DMatrix<f64>,
}

impl Scan {
    /// `base_rows` are the base columns as rows, `inverse` the inverse of their Gram matrix. `None` if
    /// the travel supports no period at all.
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "indices of wavenumbers"
    )]
    pub(crate) fn new(
        frame: &Frame,
        motion: &KnobMotion,
        band: &Band,
        angle_step_rad: f64,
        base_rows: &[Column],
        inverse: &DMatrix<f64>,
    ) -> Option<Self> {
        let sliding = || motion.angle_rad.iter().zip(&frame.mask).filter(|(_, mask)| **mask > 0.0).map(|(a, _)| *a);
        let offset_rad = motion.angle_rad.iter().copied().fold(f64::INFINITY, f64::min);
        let travel_rad = span(&sliding().collect::<Vec<_>>());
        let mut speeds: Vec<f64> = motion
            .velocity_rad_s
            .iter()
            .zip(&frame.mask)
            .filter(|(_, mask)| **mask > 0.0)
            .map(|(velocity, _)| velocity.abs())
            .collect();
        let slow_rad_s = quantile(&mut speeds, SLOW_SHARE);
        let spacing = TAU / (OVERSAMPLING * travel_rad);
        let highest = (TAU * band.edge_hz / slow_rad_s).min(FRAC_PI_2 / angle_step_rad.max(f64::MIN_POSITIVE));
        // Interpolating between angle bins needs about twenty of them per period of the finest detent.
        let last = (highest / spacing).min(LARGEST_TRANSFORM as f64 / 21.0) as usize;
        let first = (OVERSAMPLING * FEWEST_PERIODS).ceil() as usize;
        if !(travel_rad > 0.0 && last > first) {
            return None;
        }
        // The transform spans OVERSAMPLING × the travel; the full angle range may be a little wider than the sliding one.
        let length = (21 * last).next_power_of_two().clamp(1024, LARGEST_TRANSFORM);
        let mut scan = Self {
            travel_rad,
            spacing,
            first,
            last,
            offset_rad,
            bin_rad: TAU / (spacing * length as f64),
            length,
            transform: RealFftPlanner::<f64>::new().plan_fft_forward(length),
            base: Vec::new(),
            weights: Vec::new(),
            attenuation: Vec::new(),
            inverse: inverse.clone(),
        };
        scan.base = base_rows.iter().map(|rows| scan.gather(&frame.spread(rows), motion)).collect();
        scan.weights = scan.gather(&frame.mask, motion);
        let kept = frame.step as f64;
        scan.weights.iter_mut().for_each(|weight| *weight /= kept);
        scan.attenuation = scan.attenuations(frame, band, &speeds);
        Some(scan)
    }

    /// Longest and shortest period P that is searched, rad.
    #[allow(clippy::cast_precision_loss, reason = "indices of wavenumbers")]
    pub(crate) fn periods_rad(&self) -> (f64, f64) {
        (1.0 / (self.first as f64 * self.spacing), 1.0 / (self.last as f64 * self.spacing))
    }

    /// Number of independent periods among those tried.
    #[allow(clippy::cast_precision_loss, reason = "indices of wavenumbers")]
    pub(crate) fn independent(&self) -> f64 {
        ((self.last - self.first) as f64 / OVERSAMPLING).max(1.0)
    }

    /// Width of a peak, 1/rad.
    pub(crate) fn resolution(&self) -> f64 {
        TAU / self.travel_rad
    }

    /// What a detent at each wavenumber would take off the residual's sum of squares, mNm².
    #[allow(clippy::cast_precision_loss, reason = "indices of wavenumbers")]
    pub(crate) fn powers(&self, frame: &Frame, motion: &KnobMotion, residual: &[f64]) -> Vec<f64> {
        let target = self.gather(&frame.spread(residual), motion);
        (self.first..=self.last)
            .map(|index| {
                let weight = self.weights[0].re * self.attenuation[index - self.first];
                let twice = self.weights[2 * index] * self.attenuation[index - self.first];
                // Sine and cosine products against the residual and against every base column.
                let products = Vector2::new(target[index].im, target[index].re);
                let base = DMatrix::from_fn(self.base.len(), 2, |row, column| {
                    if column == 0 { self.base[row][index].im } else { self.base[row][index].re }
                });
                let explained = base.transpose() * &self.inverse * &base;
                let ridge = 3e-3 * weight;
                let gram = Matrix2::new(
                    0.5 * (weight - twice.re) - explained[(0, 0)] + ridge,
                    0.5 * twice.im - explained[(0, 1)],
                    0.5 * twice.im - explained[(1, 0)],
                    0.5 * (weight + twice.re) - explained[(1, 1)] + ridge,
                );
                // Where the base columns explain a sinusoid as well, its own share is not told.
                if gram[(0, 0)] <= 0.0 || gram.determinant() <= 0.0 {
                    return 0.0;
                }
                gram.try_inverse().map_or(0.0, |inverse| products.dot(&(inverse * products)))
            })
            .collect()
    }

    /// The strongest peaks, at least a peak's width apart, strongest first.
    #[allow(clippy::cast_precision_loss, reason = "indices of wavenumbers")]
    pub(crate) fn peaks(&self, powers: &[f64], count: usize) -> Vec<Peak> {
        let mut order: Vec<usize> = (0..powers.len())
            .filter(|index| {
                let left = index.checked_sub(1).map_or(f64::NEG_INFINITY, |left| powers[left]);
                let right = powers.get(index + 1).copied().unwrap_or(f64::NEG_INFINITY);
                powers[*index] > 0.0 && powers[*index] >= left && powers[*index] >= right
            })
            .collect();
        order.sort_by(|a, b| powers[*b].total_cmp(&powers[*a]));
        order
            .into_iter()
            .take(count)
            .map(|index| Peak { wavenumber: (index + self.first) as f64 * self.spacing, power: powers[index] })
            .collect()
    }

    /// Typical power of what is no detent around a wavenumber: the median of the neighbourhood, mNm².
    #[allow(clippy::cast_precision_loss, reason = "indices of wavenumbers")]
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
        // Two squared normal numbers have the median 2·ln 2 in units of their variance.
        median(&mut near) / (2.0 * 2_f64.ln())
    }

    /// Power of the second strongest period in what a detent of `wavenumber` left, multiples of it apart, mNm².
    ///
    /// Only periods are counted of which the travel holds at least `fewest`.
    pub(crate) fn placebo(&self, left: &[f64], wavenumber: f64, fewest: f64) -> f64 {
        let resolution = self.resolution();
        let mut others = self.peaks(left, 64).into_iter().filter(|peak| {
            let multiple = (peak.wavenumber / wavenumber).round().clamp(1.0, 3.0);
            (peak.wavenumber - multiple * wavenumber).abs() > resolution && peak.wavenumber >= fewest * resolution
        });
        let Some(strongest) = others.next() else { return 0.0 };
        others.find(|peak| (peak.wavenumber - strongest.wavenumber).abs() > resolution).map_or(0.0, |peak| peak.power)
    }

    /// Σ uₙ·exp(ikθₙ) for every multiple of the spacing.
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "indices of angle bins"
    )]
    fn gather(&self, values: &[f64], motion: &KnobMotion) -> Vec<Complex<f64>> {
        let mut bins = self.transform.make_input_vec();
        for (value, angle) in values.iter().zip(&motion.angle_rad) {
            let place = ((angle - self.offset_rad) / self.bin_rad).max(0.0);
            let index = place as usize;
            let share = place - index as f64;
            bins[index % self.length] += value * (1.0 - share);
            bins[(index + 1) % self.length] += value * share;
        }
        let mut sums = self.transform.make_output_vec();
        if self.transform.process(&mut bins, &mut sums).is_err() {
            sums.fill(Complex::new(0.0, 0.0));
        }
        // The transform has the other sign in the exponent.
        sums.iter().map(Complex::conj).collect()
    }

    /// Mean square gain of the rows' filter for a detent, over the speeds of the capture.
    #[allow(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "indices of histogram bins"
    )]
    fn attenuations(&self, frame: &Frame, band: &Band, speeds: &[f64]) -> Vec<f64> {
        const BINS: usize = 64;
        let fastest = speeds.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let mut counts = vec![0.0; BINS];
        for speed in speeds {
            counts[((speed / fastest * BINS as f64) as usize).min(BINS - 1)] += 1.0;
        }
        let total: f64 = counts.iter().sum();
        let table_hz = 3.0 * band.edge_hz / 256.0;
        let table: Vec<f64> =
            (0..=256).map(|i| frame.fir.gain(f64::from(i) * table_hz, frame.rate_hz).powi(2)).collect();
        let middles: Vec<f64> = (0..BINS).map(|bin| (bin as f64 + 0.5) / BINS as f64 * fastest / TAU).collect();
        (self.first..=self.last)
            .map(|index| {
                let wavenumber = index as f64 * self.spacing;
                let gains: Vec<f64> = middles
                    .iter()
                    .map(|turns| table.get((wavenumber * turns / table_hz).round() as usize).copied().unwrap_or(0.0))
                    .collect();
                dot(&gains, &counts) / total
            })
            .collect()
    }
}
