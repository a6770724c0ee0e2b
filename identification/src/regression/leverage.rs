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

use super::gram::restoring;
use super::long_run::{PARZEN_SQUARES, kernel_scale};
use crate::numerics::vector;

/// Most groups of rows that make half of the kernel's width: products of columns vary slowly.
const GROUPS_PER_HALF: usize = 4;

/// Inner products of the fitted columns, scaled to unit length, within the windows of the kernel.
///
/// The inner products within one window are a matrix A. Only sums over the windows of products of two elements of A are
/// needed, so these sums are computed once, for all pairs of elements.
pub(crate) struct Leverage {
    /// Number of columns, fitted or not.
    columns: usize,
    /// Those that were fitted.
    active: Vec<usize>,
    /// Their lengths.
    lengths: Vec<f64>,
    /// Their inner products over all rows.
    gram: DMatrix<f64>,
    /// ΣA over the windows, the pairs of the lower triangle row by row.
    sums: DVector<f64>,
    /// ΣA·A' of any two pairs.
    squares: DMatrix<f64>,
    /// Half the kernel's width in groups of rows.
    width: usize,
}

impl Leverage {
    /// Looks at the `active` ones of `columns` through a kernel of `bandwidth` rows.
    pub(crate) fn of<C: Deref<Target = [f64]>>(columns: &[C], active: &[usize], bandwidth: f64) -> Self {
        let half = (0.5 * bandwidth).round().max(1.0) as usize;
        let group = half.div_ceil(GROUPS_PER_HALF).max(1);
        let width = half.div_ceil(group);
        let fitted: Vec<&[f64]> = active.iter().map(|index| &*columns[*index]).collect();
        let groups = vector::grouped_products(&fitted, group);
        let totals: Vec<f64> = groups.iter().map(|groups| vector::sum(groups)).collect();
        let lengths: Vec<f64> = (0..active.len()).map(|index| totals[pair(index, index)].sqrt()).collect();
        let gram = DMatrix::from_fn(active.len(), active.len(), |row, column| {
            totals[pair(row, column)] / (lengths[row] * lengths[column])
        });
        let windows: Vec<Vec<f64>> = groups.iter().map(|groups| vector::triangle(groups, width)).collect();
        let scales: Vec<f64> = (0..active.len())
            .flat_map(|row| (0..=row).map(move |column| (row, column)))
            .map(|(row, column)| 1.0 / (lengths[row] * lengths[column]))
            .collect();
        let mut squares = vector::gram(&windows);
        squares = squares.map_with_location(|row, column, value| value * scales[row] * scales[column]);
        let sums =
            DVector::from_iterator(windows.len(), windows.iter().zip(&scales).map(|(a, scale)| scale * vector::sum(a)));
        Self { columns: columns.len(), active: active.to_vec(), lengths, gram, sums, squares, width }
    }

    /// The matrix K that corrects the scores' long-run covariance M: K·M·Kᵀ is what M would be with the errors in place of
    /// the residuals.
    pub(crate) fn correction(&self) -> DMatrix<f64> {
        let mut correction = DMatrix::identity(self.columns, self.columns);
        let count = self.active.len();
        // Without a fitted column, as where the torque is constant, nothing was lost.
        if count == 0 {
            return correction;
        }
        let Some(factor) = Cholesky::new(self.gram.clone()) else { return correction };
        let root = factor.l();
        let Some(whitening) = root.clone().try_inverse() else { return correction };
        // (W'ΦW)² is R⁻¹·A·(R·Rᵀ)⁻¹·A·R⁻ᵀ for the window A and the root R.
        let inverse = factor.inverse();
        let lost = DMatrix::from_fn(count, count, |row, column| {
            let products = |(left, right): (usize, usize)| {
                inverse[(left, right)] * self.squares[(pair(row, left), pair(right, column))]
            };
            (0..count).flat_map(|left| (0..count).map(move |right| (left, right))).map(products).sum::<f64>()
        });
        let lost = &whitening * lost * whitening.transpose() * kernel_scale(self.width);
        let inner = root * restoring(lost) * whitening;
        for (row, at) in self.active.iter().enumerate() {
            for (column, other) in self.active.iter().enumerate() {
                correction[(*at, *other)] = inner[(row, column)] * self.lengths[row] / self.lengths[column];
            }
        }
        correction
    }

    /// Degrees of freedom of the long-run variance of Σ `direction`ⱼ·scoreⱼ after Satterthwaite (Biometrics Bulletin 2, 1946, 110–114).
    ///
    /// The variance is a sum over windows of squares; their expectations a are proportional to the columns' squares in the
    /// window, and squares within the bandwidth are alike. Its relative variance, 2/ν as for a χ² with ν degrees of freedom, is
    /// 2·∫k²·Σa²/(Σa)² with Parzen's kernel k. A knob that slides forward half of the time has half of the windows to show its friction.
    pub(crate) fn degrees_of_freedom(&self, direction: &DVector<f64>) -> f64 {
        let along: Vec<f64> =
            self.active.iter().zip(&self.lengths).map(|(index, length)| direction[*index] * length).collect();
        let mut shares = DVector::zeros(self.sums.len());
        for row in 0..along.len() {
            for column in 0..=row {
                let twice = if row == column { 1.0 } else { 2.0 };
                shares[pair(row, column)] = twice * along[row] * along[column];
            }
        }
        let sum = self.sums.dot(&shares);
        let squares = shares.dot(&(&self.squares * &shares));
        let alike = PARZEN_SQUARES * 2.0 * self.width as f64;
        if squares > 0.0 { (sum * sum / (alike * squares)).max(1.0) } else { f64::INFINITY }
    }
}

/// Index of a pair in the lower triangle, row by row.
fn pair(row: usize, column: usize) -> usize {
    let (row, column) = (row.max(column), row.min(column));
    row * (row + 1) / 2 + column
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::Leverage;

    #[test]
    fn where_no_column_could_be_fitted_nothing_is_corrected() {
        let columns = [vec![0.0; 100], vec![0.0; 100]];
        assert_eq!(Leverage::of(&columns, &[], 4.0).correction(), DMatrix::identity(2, 2));
    }
}
