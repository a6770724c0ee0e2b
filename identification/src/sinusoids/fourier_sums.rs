//! Fourier sums over samples at uneven angles.

use std::f64::consts::TAU;
use std::sync::Arc;

use realfft::{RealToComplex, num_complex::Complex};

use crate::numerics::{fourier, vector};

/// Columns that are gridded together.
const TOGETHER: usize = 8;

/// Σ uₙ·exp(ikθₙ) for evenly spaced wavenumbers k at once: every value is shared out among four bins of angle by a cubic
/// spline, the bins are transformed, and the spline's own transform is divided out again (G. Beylkin, Appl. Comput. Harmon.
/// Anal. 2, 1995, 363–381).
pub(super) struct FourierSums {
    offset_rad: f64,
    bin_rad: f64,
    /// Factor that undoes the spline and its shift, for every wavenumber up to the last.
    correction: Vec<Complex<f64>>,
    transform: Arc<dyn RealToComplex<f64>>,
}

impl FourierSums {
    /// For k = 0, 1, …, `last` times the `spacing` by a transform of `length` bins, a power of two; angles count from
    /// `offset_rad`.
    pub(super) fn new(length: usize, offset_rad: f64, spacing: f64, last: usize) -> Self {
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

    /// The sums of one column.
    pub(super) fn of(&self, values: &[f64], angles: &[f64]) -> Vec<Complex<f64>> {
        let mut bins = self.transform.make_input_vec();
        // What is masked counts as zero, so it does not matter where angles beyond the sliding ones end up.
        vector::share_out(values, angles, self.offset_rad, self.bin_rad, &mut bins);
        self.transformed(&mut bins)
    }

    /// The sums of several columns with the same angles.
    pub(super) fn of_columns(&self, columns: &[&[f64]], angles: &[f64]) -> Vec<Vec<Complex<f64>>> {
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
            sums.fill(Complex::ZERO);
        }
        // The exponent of the transform is negative, that of these sums positive.
        sums.iter().zip(&self.correction).map(|(sum, correction)| sum.conj() * correction).collect()
    }
}
