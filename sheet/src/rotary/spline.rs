//! Torque over angle as a cubic spline with even knots, by least squares, which may bend sharply where detents meet.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Coefficients that reach over one place, less one.
const BAND: usize = 3;
/// Weight of a bend where there are no rows, relative to that of the rows: enough to bridge holes, far too little to be seen elsewhere.
const STIFFNESS: f64 = 1e-7;
/// How far a hinge reaches either way, in knots.
const REACH: f64 = 2.0;

/// A cubic spline with even knots (C. de Boor, A Practical Guide to Splines, 1978, chapter IX).
#[derive(Clone, Debug)]
pub(super) struct Spline {
    first: f64,
    knot: f64,
    coefficients: Vec<f64>,
    /// Where it bends sharply, rising, with the height of each hinge.
    hinges: Vec<(f64, f64)>,
}

/// A hinge of height one: |u|·(1 − u²)³, which is as smooth as the spline but for the sharp bend in its middle.
fn hinge(at: f64, middle: f64, knot: f64) -> f64 {
    let away = (at - middle).abs() / (REACH * knot);
    if away < 1.0 { away * (1.0 - away * away).powi(3) } else { 0.0 }
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
        let near = self.hinges.partition_point(|(middle, _)| *middle < at - REACH * self.knot);
        let within = self.hinges[near..].iter().take_while(|(middle, _)| *middle < at + REACH * self.knot);
        let bent: f64 = within.map(|(middle, height)| height * hinge(at, *middle, self.knot)).sum();
        self.weighted(at, basis) + bent
    }

    /// The slope at a place; in the middle of a hinge the mean of the slopes on both sides.
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
    hinges: Option<Hinges>,
}

/// The hinges of a least-squares problem.
#[derive(Debug)]
struct Hinges {
    middles: Vec<f64>,
    /// The spline through each hinge: what it shares with the others.
    shared: Vec<Vec<f64>>,
    /// What that leaves of it at every row.
    own: Vec<Vec<f64>>,
    factor: Cholesky<f64, Dyn>,
}

impl SplineFit {
    /// For rows at those places with those weights, with knots every `knot` from the first place on, and hinges at those rising
    /// places; without any where the rows do not tell all of them.
    ///
    /// `None` for fewer rows than coefficients.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a number of pieces")]
    pub(super) fn new(at: &[f64], weights: &[f64], knot: f64, hinges: &[f64]) -> Option<Self> {
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
        let weights = weights.to_vec();
        let mut fit = Self { first, knot, pieces, places, weights, factor: cholesky(normal)?, hinges: None };
        fit.hinges = fit.hinges_at(at, hinges);
        Some(fit)
    }

    fn hinges_at(&self, at: &[f64], middles: &[f64]) -> Option<Hinges> {
        if middles.is_empty() {
            return None;
        }
        let (mut shared, mut own) = (Vec::new(), Vec::new());
        for middle in middles {
            let column: Vec<f64> = at.iter().map(|at| hinge(*at, *middle, self.knot)).collect();
            let coefficients = self.coefficients(&column);
            let spline = self.spline(coefficients.clone(), Vec::new());
            own.push(at.iter().zip(&column).map(|(at, hinge)| hinge - spline.value(*at)).collect::<Vec<f64>>());
            shared.push(coefficients);
        }
        let count = middles.len();
        let gram = DMatrix::from_fn(count, count, |row, column| self.product(&own[row], &own[column]));
        Some(Hinges { middles: middles.to_vec(), shared, own, factor: Cholesky::new(gram)? })
    }

    /// Weighted product of two columns.
    fn product(&self, one: &[f64], other: &[f64]) -> f64 {
        one.iter().zip(other).zip(&self.weights).map(|((one, other), weight)| weight * one * other).sum()
    }

    fn spline(&self, coefficients: Vec<f64>, hinges: Vec<(f64, f64)>) -> Spline {
        Spline { first: self.first, knot: self.knot, coefficients, hinges }
    }

    /// Number of coefficients.
    pub(super) fn width(&self) -> usize {
        self.pieces + BAND + self.hinges.as_ref().map_or(0, |hinges| hinges.middles.len())
    }

    /// The spline through the loads.
    pub(super) fn solve(&self, loads: &[f64]) -> Spline {
        let mut coefficients = self.coefficients(loads);
        let Some(Hinges { middles, shared, own, factor }) = &self.hinges else {
            return self.spline(coefficients, Vec::new());
        };
        let told = DVector::from_iterator(own.len(), own.iter().map(|own| self.product(own, loads)));
        let heights = factor.solve(&told);
        for (shared, height) in shared.iter().zip(&heights) {
            coefficients.iter_mut().zip(shared).for_each(|(coefficient, shared)| *coefficient -= height * shared);
        }
        self.spline(coefficients, middles.iter().copied().zip(heights.iter().copied()).collect())
    }

    /// Coefficients of the smooth spline through the loads.
    fn coefficients(&self, loads: &[f64]) -> Vec<f64> {
        let mut solution = vec![0.0; self.pieces + BAND];
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
        solution
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
        let fit = SplineFit::new(&at, &vec![1.0; 200], 0.25, &[]).unwrap();
        let spline = fit.solve(&at.iter().map(|x| cubic(*x)).collect::<Vec<_>>());
        for x in [0.0, 0.33, 1.7, 3.9] {
            assert!((spline.value(x) - cubic(x)).abs() < 1e-4, "{} {}", spline.value(x), cubic(x));
            assert!((spline.slope(x) - (-2.0 + x + 0.75 * x * x)).abs() < 2e-3);
        }
    }

    #[test]
    fn a_sharp_bend_is_followed_where_a_hinge_is() {
        let bent = |x: f64| (x - 1.93).max(0.0) - 0.3 * (x - 1.93).min(0.0);
        let at: Vec<f64> = (0..400).map(|index| 0.01 * f64::from(index)).collect();
        let loads: Vec<f64> = at.iter().map(|x| bent(*x)).collect();
        let largest = |hinges: &[f64]| {
            let spline = SplineFit::new(&at, &vec![1.0; 400], 0.25, hinges).unwrap().solve(&loads);
            at.iter().map(|x| (spline.value(*x) - bent(*x)).abs()).fold(0.0, f64::max)
        };
        assert!(largest(&[]) > 0.02, "{}", largest(&[]));
        assert!(largest(&[1.93]) < 0.5 * largest(&[]), "{}", largest(&[1.93]));
    }
}
