//! The spectrum of a stretch of rows, line by line.

use crate::numerics::fourier;

/// Densities (mean squares per cycle, one-sided) at whole numbers of cycles through Hann's window, the two lowest apart;
/// frequencies are in cycles per row.
pub(crate) fn periodogram(rows: &[f64]) -> Vec<[f64; 2]> {
    if rows.len() < 8 {
        return Vec::new();
    }
    let count = rows.len() as f64;
    let bins = fourier::through_hann(rows.iter().copied(), rows.len()).unwrap_or_default();
    // Hann's window passes 3/8 of the power.
    let line = |(cycles, bin): (usize, &realfft::num_complex::Complex<f64>)| {
        [cycles as f64 / count, 2.0 * bin.norm_sqr() / (0.375 * count)]
    };
    bins.iter().enumerate().skip(2).map(line).collect()
}
