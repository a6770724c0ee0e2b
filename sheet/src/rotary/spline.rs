//! Torque over angle as a cubic spline with even knots, by least squares.

/// Coefficients that reach over one place, less one.
const BAND: usize = 3;
/// Weight of a bend where there are no rows, relative to that of the rows: enough to bridge holes, far too little to be seen elsewhere.
const STIFFNESS: f64 = 1e-7;

/// A cubic spline with even knots (C. de Boor, A Practical Guide to Splines, 1978, chapter IX).
#[derive(Clone, Debug)]
pub(super) struct Spline {
    first: f64,
    knot: f64,
    coefficients: Vec<f64>,
}

/// The four basis functions that reach over a place `share` of the way between two knots.
fn basis(share: f64) -> [f64; 4] {
    let rest = 1.0 - share;
    [
        rest.powi(3) / 6.0,
        (3.0 * share.powi(3) - 6.0 * share.powi(2) + 4.0) / 6.0,
        (3.0 * rest.powi(3) - 6.0 * rest.powi(2) + 4.0) / 6.0,
        share.powi(3) / 6.0,
    ]
}

/// Their slopes per knot distance.
fn slopes(share: f64) -> [f64; 4] {
    let rest = 1.0 - share;
    [-0.5 * rest.powi(2), 1.5 * share.powi(2) - 2.0 * share, 2.0 * rest - 1.5 * rest.powi(2), 0.5 * share.powi(2)]
}

impl Spline {
    fn place(first: f64, knot: f64, pieces: usize, at: f64) -> (usize, f64) {
        let place = ((at - first) / knot).max(0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a piece, clamped")]
        let piece = (place.floor() as usize).min(pieces - 1);
        #[allow(clippy::cast_precision_loss, reason = "a number of pieces")]
        let share = place - piece as f64;
        (piece, share.min(1.0))
    }

    fn weighted(&self, at: f64, weights: fn(f64) -> [f64; 4]) -> f64 {
        let (piece, share) = Self::place(self.first, self.knot, self.coefficients.len() - BAND, at);
        weights(share).iter().zip(&self.coefficients[piece..]).map(|(weight, value)| weight * value).sum()
    }

    /// The value at a place.
    pub(super) fn value(&self, at: f64) -> f64 {
        self.weighted(at, basis)
    }

    /// The slope at a place.
    pub(super) fn slope(&self, at: f64) -> f64 {
        self.weighted(at, slopes) / self.knot
    }
}

/// The least-squares problem, factorised: any number of loads at the same places.
#[derive(Debug)]
pub(super) struct SplineFit {
    first: f64,
    pub(super) knot: f64,
    pieces: usize,
    places: Vec<(usize, f64)>,
    weights: Vec<f64>,
    /// Rows of the Cholesky factor from its diagonal to the left.
    factor: Vec<[f64; BAND + 1]>,
}

impl SplineFit {
    /// For rows at those places with those weights, with knots every `knot` from the first place on.
    ///
    /// `None` for fewer rows than coefficients.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of pieces")]
    pub(super) fn new(at: &[f64], weights: &[f64], knot: f64) -> Option<Self> {
        let first = at.iter().copied().fold(f64::INFINITY, f64::min);
        let last = at.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let pieces = (((last - first) / knot).ceil() as usize).max(1);
        if at.len() < pieces + BAND {
            return None;
        }
        let places: Vec<(usize, f64)> = at.iter().map(|at| Spline::place(first, knot, pieces, *at)).collect();
        let mut normal = vec![[0.0; BAND + 1]; pieces + BAND];
        for ((piece, share), weight) in places.iter().zip(weights) {
            let basis = basis(*share);
            for row in 0..=BAND {
                for column in 0..=row {
                    normal[piece + row][row - column] += weight * basis[row] * basis[column];
                }
            }
        }
        let bend = STIFFNESS * weights.iter().sum::<f64>() / (pieces + BAND) as f64;
        for middle in 1..normal.len() - 1 {
            let second = [1.0, -2.0, 1.0];
            for row in 0..3 {
                for column in 0..=row {
                    normal[middle - 1 + row][row - column] += bend * second[row] * second[column];
                }
            }
        }
        Some(Self { first, knot, pieces, places, weights: weights.to_vec(), factor: cholesky(normal)? })
    }

    /// Number of coefficients.
    pub(super) fn width(&self) -> usize {
        self.pieces + BAND
    }

    /// The spline through the loads.
    pub(super) fn solve(&self, loads: &[f64]) -> Spline {
        let mut solution = vec![0.0; self.width()];
        for (((piece, share), weight), load) in self.places.iter().zip(&self.weights).zip(loads) {
            for (offset, basis) in basis(*share).iter().enumerate() {
                solution[piece + offset] += weight * basis * load;
            }
        }
        for row in 0..solution.len() {
            let known: f64 = (1..=BAND.min(row)).map(|back| self.factor[row][back] * solution[row - back]).sum();
            solution[row] = (solution[row] - known) / self.factor[row][0];
        }
        for row in (0..solution.len()).rev() {
            let last = (row + BAND).min(solution.len() - 1);
            let known: f64 = (row + 1..=last).map(|after| self.factor[after][after - row] * solution[after]).sum();
            solution[row] = (solution[row] - known) / self.factor[row][0];
        }
        Spline { first: self.first, knot: self.knot, coefficients: solution }
    }
}

/// The Cholesky factor of a banded matrix; `None` if it is not positive definite.
fn cholesky(mut matrix: Vec<[f64; BAND + 1]>) -> Option<Vec<[f64; BAND + 1]>> {
    for row in 0..matrix.len() {
        for back in (0..=BAND.min(row)).rev() {
            let column = row - back;
            let shared = (column.saturating_sub(BAND).max(row.saturating_sub(BAND))..column)
                .map(|other| matrix[row][row - other] * matrix[column][column - other])
                .sum::<f64>();
            let rest = matrix[row][back] - shared;
            matrix[row][back] = match back {
                0 if rest > 0.0 => rest.sqrt(),
                0 => return None,
                _ => rest / matrix[column][0],
            };
        }
    }
    Some(matrix)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use super::SplineFit;

    #[test]
    fn a_cubic_comes_back_exactly_with_its_slope() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x + 0.25 * x.powi(3);
        let at: Vec<f64> = (0..200).map(|index| 0.02 * f64::from(index)).collect();
        let fit = SplineFit::new(&at, &vec![1.0; 200], 0.25).unwrap();
        let spline = fit.solve(&at.iter().map(|x| cubic(*x)).collect::<Vec<_>>());
        for x in [0.0, 0.33, 1.7, 3.9] {
            assert!((spline.value(x) - cubic(x)).abs() < 1e-4, "{} {}", spline.value(x), cubic(x));
            assert!((spline.slope(x) - (-2.0 + x + 0.75 * x * x)).abs() < 2e-3);
        }
    }
}
