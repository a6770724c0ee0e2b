//! Torque over angle as a cubic spline with even knots, by least squares, which may bend sharply where detents meet.

use super::banded::{Banded, BandedCholesky};

/// Degree of the spline: one less than the number of basis functions that are not zero at a place.
const BAND: usize = 3;
/// Weight of a bend where there are no rows, relative to that of the rows: enough to bridge holes, far too little to be seen elsewhere.
const STIFFNESS: f64 = 1e-7;

/// A cubic spline with even knots (C. de Boor, A Practical Guide to Splines, 1978, chapter IX).
#[derive(Clone, Debug)]
pub(super) struct Spline {
    first: f64,
    knot: f64,
    coefficients: Vec<f64>,
    /// Where it bends sharply, rising, with the height of each hinge.
    hinges: Vec<(f64, f64)>,
    /// How far a hinge reaches either way.
    reach: f64,
}

/// A hinge of height one: |u|·(1 − u²)³, which is as smooth as the spline but for the sharp bend in its middle.
fn hinge(at: f64, middle: f64, reach: f64) -> f64 {
    let away = (at - middle).abs() / reach;
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
        let piece = (place.floor() as usize).min(pieces - 1);
        let share = place - piece as f64;
        (piece, share.min(1.0))
    }

    fn weighted(&self, at: f64, weights: fn(f64) -> [f64; 4]) -> f64 {
        let (piece, share) = Self::place(self.first, self.knot, self.coefficients.len() - BAND, at);
        weights(share).iter().zip(&self.coefficients[piece..]).map(|(weight, value)| weight * value).sum()
    }

    /// The value at a place.
    pub(super) fn value(&self, at: f64) -> f64 {
        let near = self.hinges.partition_point(|(middle, _)| *middle < at - self.reach);
        let within = self.hinges[near..].iter().take_while(|(middle, _)| *middle < at + self.reach);
        let bent: f64 = within.map(|(middle, height)| height * hinge(at, *middle, self.reach)).sum();
        self.weighted(at, basis) + bent
    }

    /// The slope at a place; in the middle of a hinge the mean of the slopes on both sides.
    pub(super) fn slope(&self, at: f64) -> f64 {
        self.weighted(at, slopes) / self.knot
    }
}

/// A coefficient: of a basis function of the smooth spline or of a hinge.
#[derive(Clone, Copy, Debug)]
enum Unknown {
    Basis(usize),
    Hinge(usize),
}

/// The least-squares problem, factorised: any number of loads at the same places.
#[derive(Clone, Debug)]
pub(super) struct SplineFit {
    first: f64,
    pub(super) knot: f64,
    hinges: Vec<f64>,
    reach: f64,
    /// The unknowns in the order of their places, so that those which meet in a row are neighbours.
    unknowns: Vec<Unknown>,
    /// The non-zero elements of the design matrix, row by row: the unknown's index and the value.
    rows: Vec<Vec<(usize, f64)>>,
    weights: Vec<f64>,
    factor: BandedCholesky,
}

impl SplineFit {
    /// The problem for rows at the places `at` with `weights`, with knots every `knot` from the first place on, and `hinges` that
    /// reach `reach` to either side.
    ///
    /// `None` for fewer rows than coefficients, or rows that do not determine them all.
    pub(super) fn new(at: &[f64], weights: &[f64], knot: f64, hinges: &[f64], reach: f64) -> Option<Self> {
        let first = at.iter().copied().fold(f64::INFINITY, f64::min);
        let last = at.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let pieces = (((last - first) / knot).ceil() as usize).max(1);
        let bases = pieces + BAND;
        if at.len() < bases + hinges.len() {
            return None;
        }
        let middle = |unknown: &Unknown| match unknown {
            Unknown::Basis(index) => first + (*index as f64 - 1.0) * knot,
            Unknown::Hinge(index) => hinges[*index],
        };
        let mut unknowns: Vec<Unknown> =
            (0..bases).map(Unknown::Basis).chain((0..hinges.len()).map(Unknown::Hinge)).collect();
        unknowns.sort_by(|a, b| middle(a).total_cmp(&middle(b)));
        let (mut of_basis, mut of_hinge) = (vec![0; bases], vec![0; hinges.len()]);
        for (place, unknown) in unknowns.iter().enumerate() {
            match unknown {
                Unknown::Basis(index) => of_basis[*index] = place,
                Unknown::Hinge(index) => of_hinge[*index] = place,
            }
        }
        let row = |at: &f64| {
            let (piece, share) = Spline::place(first, knot, pieces, *at);
            let smooth = basis(share).into_iter().enumerate().map(|(offset, value)| (of_basis[piece + offset], value));
            let bent = hinges.iter().zip(&of_hinge).map(|(middle, place)| (*place, hinge(*at, *middle, reach)));
            smooth.chain(bent.filter(|(_, value)| *value > 0.0)).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<(usize, f64)>> = at.iter().map(row).collect();
        let bend = (STIFFNESS * weights.iter().sum::<f64>() / bases as f64).sqrt();
        let bends = (1..bases - 1).map(|index| {
            [(index - 1, bend), (index, -2.0 * bend), (index + 1, bend)]
                .map(|(index, value)| (of_basis[index], value))
                .to_vec()
        });
        let mut normal = Banded::new(unknowns.len());
        rows.iter().zip(weights).for_each(|(row, weight)| normal.add(row, *weight));
        bends.for_each(|row| normal.add(&row, 1.0));
        let (hinges, weights) = (hinges.to_vec(), weights.to_vec());
        Some(Self { first, knot, hinges, reach, unknowns, rows, weights, factor: normal.cholesky()? })
    }

    /// Number of coefficients.
    pub(super) fn width(&self) -> usize {
        self.unknowns.len()
    }

    /// The spline through the loads.
    pub(super) fn solve(&self, loads: &[f64]) -> Spline {
        let mut sums = vec![0.0; self.width()];
        for ((row, weight), load) in self.rows.iter().zip(&self.weights).zip(loads) {
            row.iter().for_each(|(place, value)| sums[*place] += weight * value * load);
        }
        let solution = self.factor.solve(sums);
        let mut spline = Spline {
            first: self.first,
            knot: self.knot,
            coefficients: Vec::new(),
            hinges: Vec::new(),
            reach: self.reach,
        };
        for (unknown, value) in self.unknowns.iter().zip(solution) {
            match unknown {
                Unknown::Basis(_) => spline.coefficients.push(value),
                Unknown::Hinge(index) => spline.hinges.push((self.hinges[*index], value)),
            }
        }
        spline
    }

    /// How much of each row's own noise the spline follows, 0 to 1: its leverage.
    pub(super) fn leverages(&self) -> Vec<f64> {
        self.rows.iter().zip(&self.weights).map(|(row, weight)| weight * self.factor.inverse_norm(row)).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]

    use super::SplineFit;

    #[test]
    fn a_cubic_comes_back_exactly_with_its_slope() {
        let cubic = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x + 0.25 * x.powi(3);
        let at: Vec<f64> = (0..200).map(|index| 0.02 * f64::from(index)).collect();
        let fit = SplineFit::new(&at, &vec![1.0; 200], 0.25, &[], 0.0).unwrap();
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
            let spline = SplineFit::new(&at, &vec![1.0; 400], 0.25, hinges, 1.5).unwrap().solve(&loads);
            at.iter().map(|x| (spline.value(*x) - bent(*x)).abs()).fold(0.0, f64::max)
        };
        assert!(largest(&[]) > 0.02, "{}", largest(&[]));
        assert!(largest(&[1.93]) < 0.1 * largest(&[]), "{}", largest(&[1.93]));
    }
}
