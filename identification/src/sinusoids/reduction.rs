//! What a sinusoid of the angle takes off a sum of squares, beside base columns that are fitted anyway.

use nalgebra::DMatrix;
use realfft::num_complex::Complex;

/// Share of a sinusoid's square that is added to it twice over, so that one that the base columns nearly explain is not
/// estimated from rounding.
const RIDGE: f64 = 3e-3;

/// The reduction of a sum of squares by a·sin(kθ) + b·cos(kθ): a quadratic form of the residual's products with sine and
/// cosine, whose matrix is the inverse of their Gram matrix.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reduction {
    sine_square: f64,
    /// Of both entries off the diagonal.
    sine_cosine: f64,
    cosine_square: f64,
}

impl Reduction {
    /// For the wavenumber of an `index`, at which the rows' filter has the mean square gain `attenuation`; zero where the base
    /// columns can do all that the sinusoid can.
    ///
    /// `base` and `weights` are Fourier sums of the base columns and of the mask, `inverse` is that of the base columns' Gram
    /// matrix.
    pub(crate) fn new(
        index: usize,
        attenuation: f64,
        base: &[Vec<Complex<f64>>],
        weights: &[Complex<f64>],
        inverse: &DMatrix<f64>,
    ) -> Self {
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
            return Self { sine_square: 0.0, sine_cosine: 0.0, cosine_square: 0.0 };
        }
        Self {
            sine_square: gram[2] / determinant,
            sine_cosine: -2.0 * gram[1] / determinant,
            cosine_square: gram[0] / determinant,
        }
    }

    /// The reduction for a residual with this Fourier sum at the wavenumber.
    pub(crate) fn of(&self, residual: Complex<f64>) -> f64 {
        let Self { sine_square, sine_cosine, cosine_square } = self;
        sine_square * residual.im * residual.im
            + sine_cosine * residual.im * residual.re
            + cosine_square * residual.re * residual.re
    }
}
