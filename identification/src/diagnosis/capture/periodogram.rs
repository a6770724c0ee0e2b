//! The spectrum of a stretch of rows, line by line.

use std::f64::consts::PI;

use crate::numerics::fourier;

/// Densities (mean squares per cycle, one-sided) at whole numbers of cycles through Hann's window, the two lowest apart;
/// frequencies are in cycles per row.
pub(crate) fn periodogram(rows: &[f64]) -> Vec<[f64; 2]> {
    if rows.len() < 8 {
        return Vec::new();
    }
    let count = rows.len() as f64;
    let transform = fourier::forward(rows.len());
    let mut windowed = transform.make_input_vec();
    for (index, (slot, row)) in windowed.iter_mut().zip(rows).enumerate() {
        *slot = row * (PI * (index as f64 + 0.5) / count).sin().powi(2);
    }
    let mut bins = transform.make_output_vec();
    if transform.process(&mut windowed, &mut bins).is_err() {
        return Vec::new();
    }
    // Hann's window passes 3/8 of the power.
    let line = |(cycles, bin): (usize, &realfft::num_complex::Complex<f64>)| {
        [cycles as f64 / count, 2.0 * bin.norm_sqr() / (0.375 * count)]
    };
    bins.iter().enumerate().skip(2).map(line).collect()
}
