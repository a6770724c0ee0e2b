//! Symmetric matrices of which only a band about the diagonal is not zero.

/// Share of the norm, which is at most one, below which a squared value is negligible.
const NEGLIGIBLE: f64 = 1e-9;

/// A symmetric matrix: each row holds the value on the diagonal, then the values to its left, nearest first.
#[derive(Debug)]
pub(super) struct Banded {
    rows: Vec<Vec<f64>>,
}

/// The Cholesky factor of a [`Banded`] matrix.
#[derive(Clone, Debug)]
pub(super) struct BandedCholesky {
    rows: Vec<Vec<f64>>,
    width: usize,
}

impl Banded {
    pub(super) fn new(size: usize) -> Self {
        Self { rows: vec![vec![0.0]; size] }
    }

    /// Adds the product of a sparse row with itself.
    pub(super) fn add(&mut self, row: &[(usize, f64)], weight: f64) {
        for (at, value) in row {
            for (other, factor) in row.iter().filter(|(other, _)| other <= at) {
                let band = &mut self.rows[*at];
                band.resize(band.len().max(at - other + 1), 0.0);
                band[at - other] += weight * value * factor;
            }
        }
    }

    /// `None` if the matrix is not positive definite.
    pub(super) fn cholesky(self) -> Option<BandedCholesky> {
        let width = self.rows.iter().map(Vec::len).max().unwrap_or(1);
        let mut rows = self.rows;
        for at in 0..rows.len() {
            let (above, row) = rows.split_at_mut(at);
            let row = &mut row[0];
            row.resize(width.min(at + 1), 0.0);
            for back in (1..row.len()).rev() {
                let pivot = &above[at - back];
                let shared: f64 = pivot[1..].iter().zip(&row[back + 1..]).map(|(a, b)| a * b).sum();
                row[back] = (row[back] - shared) / pivot[0];
            }
            let rest = row[0] - row[1..].iter().map(|value| value * value).sum::<f64>();
            row[0] = (rest > 0.0).then(|| rest.sqrt())?;
        }
        Some(BandedCholesky { rows, width })
    }
}

impl BandedCholesky {
    /// The solution of the equations with that right side.
    pub(super) fn solve(&self, mut values: Vec<f64>) -> Vec<f64> {
        for at in 0..values.len() {
            values[at] = self.forward(&values, at);
        }
        for (at, row) in self.rows.iter().enumerate().rev() {
            values[at] /= row[0];
            for (back, factor) in row.iter().enumerate().skip(1) {
                values[at - back] -= factor * values[at];
            }
        }
        values
    }

    /// `row · A⁻¹ · row` for a sparse row.
    pub(super) fn inverse_norm(&self, row: &[(usize, f64)]) -> f64 {
        let first = row.iter().map(|(at, _)| *at).min().unwrap_or(0);
        let mut values = vec![0.0; self.rows.len()];
        row.iter().for_each(|(at, value)| values[*at] = *value);
        let (mut norm, mut last) = (0.0, 0);
        for at in first..values.len() {
            values[at] = self.forward(&values, at);
            norm += values[at] * values[at];
            // What comes after decays from knot to knot.
            if values[at].powi(2) > NEGLIGIBLE * norm {
                last = at;
            } else if at > last + self.width {
                break;
            }
        }
        norm
    }

    fn forward(&self, values: &[f64], at: usize) -> f64 {
        let row = &self.rows[at];
        let known: f64 = row.iter().enumerate().skip(1).map(|(back, factor)| factor * values[at - back]).sum();
        (values[at] - known) / row[0]
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use nalgebra::{DMatrix, DVector};

    use super::Banded;

    #[test]
    fn solutions_and_norms_are_those_of_the_full_matrix() {
        let rows: Vec<Vec<(usize, f64)>> = (0..30_u32)
            .map(|index| {
                let at = (index / 3) as usize;
                vec![(at, 1.0), (at + 2, f64::from(index % 7) - 3.0), (at + 1, f64::from(index % 5))]
            })
            .collect();
        let (mut banded, mut full) = (Banded::new(12), DMatrix::<f64>::zeros(12, 12));
        for row in &rows {
            banded.add(row, 2.0);
            for (at, value) in row {
                row.iter().for_each(|(other, factor)| full[(*at, *other)] += 2.0 * value * factor);
            }
        }
        let (banded, inverse) = (banded.cholesky().unwrap(), full.try_inverse().unwrap());
        let right = DVector::from_fn(12, |at, _| at as f64 - 4.0);
        let solution = banded.solve(right.iter().copied().collect());
        for (ours, theirs) in solution.iter().zip((&inverse * &right).iter()) {
            assert!((ours - theirs).abs() < 1e-9, "{ours} {theirs}");
        }
        let row = rows[7].iter().fold(DVector::zeros(12), |mut row, (at, value)| {
            row[*at] += *value;
            row
        });
        let norm = row.dot(&(&inverse * &row));
        assert!((banded.inverse_norm(&rows[7]) - norm).abs() < 1e-6 * norm);
    }
}
