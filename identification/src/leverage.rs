//! How much of the errors' long-run variance the residuals have lost to the fit, and how well it is known.
//!
//! A fit of k columns takes from the residual what the columns can do, and it takes most of it where few rows carry a
//! parameter. Sums of scores over the bandwidth see this more than single rows do: over a tenth of a second all columns
//! look alike, so that each window loses nearly k of its own degrees of freedom and not one. For the windows φ of the
//! kernel, W the columns made orthonormal and errors alike in all rows, the scores' covariance comes out as
//!
//! ```text
//! E Σ_w W'Φ_w·ê·ê'Φ_w·W = σ²·(1 − Q),   Q = Σ_w (W'Φ_w·W)²,   Σ_w φ_w² = 1
//! ```
//!
//! and (1 − Q)^(−1/2) on both sides makes it right: the bias-reduced linearisation of R. M. Bell and D. F. McCaffrey
//! (Survey Methodology 28, 2002, 169–181), with overlapping windows in place of clusters.

use std::ops::Deref;

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::long_run::{PARZEN_SQUARES, boxed, kernel_scale};

/// Places at which half of the kernel is told apart: products of columns vary slowly.
const PLACES_PER_HALF: usize = 4;
/// Least share of a variance that is taken for left: of less, nothing can be said.
const LEAST_LEFT: f64 = 0.1;

/// Inner products of the columns within each window of the kernel.
pub(crate) struct Leverage {
    columns: usize,
    /// Every pair's products, summed over the triangle at each place; the pairs of the lower triangle row by row.
    windows: Vec<Vec<f64>>,
    /// The same over all rows.
    gram: DMatrix<f64>,
    /// Half the kernel's width in places.
    width: usize,
}

impl Leverage {
    /// Looks at `columns` through a kernel of `bandwidth` rows.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of rows")]
    pub(crate) fn of<C: Deref<Target = [f64]>>(columns: &[C], bandwidth: f64) -> Self {
        let half = (0.5 * bandwidth).round().max(1.0) as usize;
        let group = half.div_ceil(PLACES_PER_HALF).max(1);
        let width = half.div_ceil(group);
        let mut gram = DMatrix::zeros(columns.len(), columns.len());
        let mut windows = Vec::new();
        for (row, left) in columns.iter().enumerate() {
            for (column, right) in columns[..=row].iter().enumerate() {
                let parts = left.chunks(group).zip(right.chunks(group));
                let places: Vec<f64> =
                    parts.map(|(left, right)| left.iter().zip(right).map(|(a, b)| a * b).sum()).collect();
                gram[(row, column)] = places.iter().sum();
                gram[(column, row)] = gram[(row, column)];
                windows.push(boxed(&boxed(&places, width), width));
            }
        }
        Self { columns: columns.len(), windows, gram, width }
    }

    /// The matrix K that makes K·M·Kᵀ of the scores' long-run covariance M what it would be of errors in place of
    /// residuals; `active` are the columns that were fitted.
    pub(crate) fn correction(&self, active: &[usize]) -> DMatrix<f64> {
        let mut correction = DMatrix::identity(self.columns, self.columns);
        let part = DMatrix::from_fn(active.len(), active.len(), |row, column| {
            self.gram[(active[row], active[column])] / (self.scale(active[row]) * self.scale(active[column]))
        });
        let Some(factor) = Cholesky::new(part) else { return correction };
        let root = factor.l();
        let Some(whitening) = root.clone().try_inverse() else { return correction };
        let mut lost = DMatrix::zeros(active.len(), active.len());
        let mut window = DMatrix::zeros(active.len(), active.len());
        let mut halfway = lost.clone();
        for place in 0..self.windows.first().map_or(0, Vec::len) {
            for (row, at) in active.iter().enumerate() {
                for (column, other) in active.iter().enumerate().take(row + 1) {
                    let value = self.product(place, *at, *other) / (self.scale(*at) * self.scale(*other));
                    window[(row, column)] = value;
                    window[(column, row)] = value;
                }
            }
            // (W'ΦW)² is R⁻¹·A·(R·Rᵀ)⁻¹·A·R⁻ᵀ for the window A and the root R; the outer factors wait until the end.
            whitening.mul_to(&window, &mut halfway);
            lost.gemm_tr(1.0, &halfway, &halfway, 1.0);
        }
        let lost = &whitening * lost * whitening.transpose() * kernel_scale(self.width);
        let left = (DMatrix::identity(active.len(), active.len()) - lost).symmetric_eigen();
        let powers = DMatrix::from_diagonal(&left.eigenvalues.map(|share| share.max(LEAST_LEFT).powf(-0.5)));
        let enlarged = &left.eigenvectors * powers * left.eigenvectors.transpose();
        let inner = root * enlarged * whitening;
        for (row, at) in active.iter().enumerate() {
            for (column, other) in active.iter().enumerate() {
                correction[(*at, *other)] = inner[(row, column)] * self.scale(*at) / self.scale(*other);
            }
        }
        correction
    }

    /// Degrees of freedom of the long-run variance of Σ `direction`ⱼ·scoreⱼ: those of a χ² that varies as much, after Satterthwaite (Biometrics Bulletin 2, 1946, 110–114).
    ///
    /// The variance is a sum over windows of squares whose expectations a go with the columns' squares there, and
    /// which are alike over the bandwidth: it varies by 2/ν = 2·∫k²·Σa² over (Σa)², k Parzen's kernel. A knob that slides
    /// forward half of the time has half of the windows to tell its friction by.
    #[allow(clippy::cast_precision_loss, reason = "a number of places")]
    pub(crate) fn degrees_of_freedom(&self, direction: &DVector<f64>) -> f64 {
        let (mut sum, mut squares) = (0.0, 0.0);
        for place in 0..self.windows.first().map_or(0, Vec::len) {
            let mut size = 0.0;
            let mut pair = 0;
            for row in 0..self.columns {
                for column in 0..=row {
                    let twice = if row == column { 1.0 } else { 2.0 };
                    size += twice * direction[row] * direction[column] * self.windows[pair][place];
                    pair += 1;
                }
            }
            sum += size;
            squares += size * size;
        }
        let alike = PARZEN_SQUARES * 2.0 * self.width as f64;
        if squares > 0.0 { (sum * sum / (alike * squares)).max(1.0) } else { f64::INFINITY }
    }

    fn product(&self, place: usize, row: usize, column: usize) -> f64 {
        let (row, column) = (row.max(column), row.min(column));
        self.windows[row * (row + 1) / 2 + column][place]
    }

    fn scale(&self, column: usize) -> f64 {
        self.gram[(column, column)].sqrt()
    }
}
