//! Sinusoids of the angle, wavenumber by wavenumber: what each explains, and which of them stands out.

use std::f64::consts::TAU;

use nalgebra::DMatrix;
use realfft::num_complex::Complex;

use crate::statistics::median;

/// Fewest periods that the travel must hold for one to be identified.
pub(crate) const FEWEST_PERIODS: f64 = 1.25;
/// Share of a sinusoid's square that is added to it twice over, so that one that the base columns nearly explain is not made
/// of rounding.
const RIDGE: f64 = 3e-3;

/// A period that stands out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peak {
    /// Wavenumber 1/P, 1/rad.
    pub(crate) wavenumber: f64,
    /// Sum of squares that a detent of this period takes away, mNm².
    pub(crate) power: f64,
}

/// Wavenumbers at equal distances.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wavenumbers {
    travel_rad: f64,
    /// Distance of two, 1/rad.
    pub(crate) spacing: f64,
    /// The first and the last, in units of the distance.
    pub(crate) first: usize,
    pub(crate) last: usize,
}

impl Wavenumbers {
    /// From that of which the travel holds just enough periods up to the number `last`; `None` if there are none.
    pub(crate) fn of(travel_rad: f64, spacing: f64, last: usize) -> Option<Self> {
        let mut all = Self { travel_rad, spacing, first: 0, last };
        all.first = (all.steps() * FEWEST_PERIODS).ceil() as usize;
        (travel_rad > 0.0 && last > all.first).then_some(all)
    }

    /// Wavenumbers in the width of a peak.
    fn steps(&self) -> f64 {
        self.resolution() / self.spacing
    }

    /// Longest and shortest period P that is searched, rad.
    pub(crate) fn periods_rad(&self) -> (f64, f64) {
        (1.0 / (self.first as f64 * self.spacing), 1.0 / (self.last as f64 * self.spacing))
    }

    /// Number of independent periods among those tried.
    fn independent(&self) -> f64 {
        ((self.last - self.first) as f64 / self.steps()).max(1.0)
    }

    /// Width of a peak, 1/rad.
    pub(crate) fn resolution(&self) -> f64 {
        TAU / self.travel_rad
    }

    /// How far above the background the best of the independent periods stands by chance, and `margin` more.
    pub(crate) fn needed(&self, margin: f64) -> f64 {
        2.0 * self.independent().ln() + margin
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
            .map(|index| Peak {
                wavenumber: ((index + self.first) as f64 + top(powers, index)) * self.spacing,
                power: powers[index],
            })
            .collect()
    }

    /// Largest power within a peak's width of a wavenumber, mNm²; `None` beyond what was searched.
    pub(crate) fn near(&self, powers: &[f64], wavenumber: f64) -> Option<f64> {
        let place = (wavenumber / self.spacing).round() as usize;
        let width = self.steps().round() as usize;
        let from = place.saturating_sub(width).checked_sub(self.first)?;
        let part = powers.get(from..=from + 2 * width)?;
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
        // Two squared normal numbers have the median 2·ln 2 in units of their variance.
        median(&mut near) / (2.0 * 2_f64.ln())
    }

    /// The null test of a detent of `wavenumber`: power of the second strongest period in what it left, multiples of it
    /// apart, mNm².
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
}

/// Where the parabola through a peak and its neighbours has its top, in steps from the peak.
fn top(powers: &[f64], index: usize) -> f64 {
    let at = |index: Option<usize>| index.and_then(|index| powers.get(index)).copied();
    let (Some(left), Some(right)) = (at(index.checked_sub(1)), at(Some(index + 1))) else { return 0.0 };
    let bend = 2.0 * powers[index] - left - right;
    if bend > 0.0 { 0.5 * (right - left) / bend } else { 0.0 }
}

/// Inverse of the Gram matrix of sine and cosine beside base columns: sine with itself, twice sine with cosine, cosine with
/// itself; zeros where the base columns explain a sinusoid as well.
///
/// `base` and `weights` are Fourier sums of the base columns and of the mask, `inverse` is the inverse of the base columns' Gram
/// matrix; at the wavenumber of the `index` the rows' filter has the mean square gain `attenuation`.
pub(crate) fn inverse_beside(
    index: usize,
    attenuation: f64,
    base: &[Vec<Complex<f64>>],
    weights: &[Complex<f64>],
    inverse: &DMatrix<f64>,
) -> [f64; 3] {
    let diagonal = 0.5 * weights[0].re * attenuation * (1.0 + 2.0 * RIDGE);
    let mut gram = [diagonal, 0.0, diagonal];
    if let Some(twice) = weights.get(2 * index) {
        let twice = 0.5 * attenuation * twice;
        gram = [diagonal - twice.re, twice.im, diagonal + twice.re];
        // What the base columns explain of sine and cosine.
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

/// What a sinusoid takes off a residual's sum of squares, from the residual's Fourier sum and [`inverse_beside`].
pub(crate) fn power(sum: Complex<f64>, [sine, mixed, cosine]: [f64; 3]) -> f64 {
    sine * sum.im * sum.im + mixed * sum.im * sum.re + cosine * sum.re * sum.re
}
