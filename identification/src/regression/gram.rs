//! Inner products of a target and its columns: all of the rows that least squares needs.

use std::ops::{AddAssign, Deref};

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::vector;

/// A column of which less than this share of the square remains beside the others is collinear.
const COLLINEAR: f64 = 1e-9;
/// What holds a coefficient of either sign near zero, as a share of its column's square: too little to be felt unless
/// other columns can do the same.
const HELD: f64 = 1e-8;
/// The same for coefficients that cannot be negative.
const FIRM: f64 = 1e-11;

/// A correction that would move the prediction by less than this share of the target is rounding, …
const SETTLED: f64 = 1e-15;
/// … and one by less than this share of the residual is a billionth of a standard deviation.
const NEGLIGIBLE: f64 = 1e-9;
/// Most corrections.
const ROUNDS: usize = 3;

/// Inner products over rows: of the target, which comes first, and of the columns.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gram {
    sums: DMatrix<f64>,
}

/// What becomes of columns that are sums of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Collinear {
    /// They are left out and marked.
    LeftOut,
    /// All take part. As an offset is the sum of two levels of friction, the one that may have either sign is held small:
    /// it takes over only what the others, at their bounds, cannot do.
    HeldSmall,
}

/// Coefficients, one per column.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Zero for those left out.
    pub(crate) coefficients: Vec<f64>,
    /// Inverse of the columns' Gram matrix, zero in the rows and columns of those left out.
    pub(crate) inverse: DMatrix<f64>,
    /// Columns that are sums of earlier ones, or empty.
    pub(crate) collinear: Vec<bool>,
    /// Columns held at zero because their coefficient would be negative.
    pub(crate) at_zero: Vec<bool>,
}

impl Solution {
    /// Indices of the columns that were fitted.
    pub(crate) fn fitted(&self) -> Vec<usize> {
        (0..self.coefficients.len()).filter(|index| !self.collinear[*index] && !self.at_zero[*index]).collect()
    }
}

impl AddAssign<&Self> for Gram {
    fn add_assign(&mut self, other: &Self) {
        self.sums += &other.sums;
    }
}

impl Gram {
    /// Of no rows, for so many columns.
    pub(crate) fn empty(columns: usize) -> Self {
        Self { sums: DMatrix::zeros(columns + 1, columns + 1) }
    }

    pub(crate) fn of<C: Deref<Target = [f64]>>(columns: &[C], target: &[f64]) -> Self {
        let mut gram = Self::empty(0);
        gram.replace(0, columns, target);
        gram
    }

    /// Forms the products of the columns from `first` on anew, whose number may have changed.
    pub(crate) fn replace<C: Deref<Target = [f64]>>(&mut self, first: usize, columns: &[C], target: &[f64]) {
        let sums = std::mem::replace(&mut self.sums, DMatrix::zeros(0, 0));
        self.sums = sums.resize(columns.len() + 1, columns.len() + 1, 0.0);
        let all: Vec<&[f64]> = std::iter::once(target).chain(columns.iter().map(|column| &**column)).collect();
        vector::products(&all, if first == 0 { 0 } else { first + 1 }, &mut self.sums);
    }

    /// Adds a row: the target's value, then the columns'.
    pub(crate) fn add_row(&mut self, row: &[f64]) {
        for (column, right) in row.iter().enumerate() {
            for (sum, left) in self.sums.column_mut(column).iter_mut().zip(row) {
                *sum += left * right;
            }
        }
    }

    /// Number of columns.
    pub(crate) fn columns(&self) -> usize {
        self.sums.nrows() - 1
    }

    /// Sum of squares of the target.
    pub(crate) fn total(&self) -> f64 {
        self.sums[(0, 0)]
    }

    /// Square of a column's length.
    pub(crate) fn square(&self, column: usize) -> f64 {
        self.sums[(column + 1, column + 1)]
    }

    /// The same target with some of the columns.
    pub(crate) fn chosen(&self, columns: &[usize]) -> Self {
        let places: Vec<usize> = std::iter::once(0).chain(columns.iter().map(|column| column + 1)).collect();
        Self { sums: self.sums.select_rows(&places).select_columns(&places) }
    }

    /// Sum of squares that the columns leave of the target.
    pub(crate) fn least(&self) -> f64 {
        self.left(&self.solve().coefficients)
    }

    /// The same target with columns that are sums of these: a row of `map` for each.
    pub(crate) fn mapped(&self, map: &DMatrix<f64>) -> Self {
        let mut whole = map.clone().insert_row(0, 0.0).insert_column(0, 0.0);
        whole[(0, 0)] = 1.0;
        Self { sums: &whole * &self.sums * whole.transpose() }
    }

    /// Takes off what noise adds to a column's square and to its product with the target.
    pub(super) fn take_off(&mut self, column: usize, square: f64, product: f64) {
        self.sums[(column + 1, column + 1)] -= square;
        self.sums[(0, column + 1)] -= product;
        self.sums[(column + 1, 0)] -= product;
    }

    /// Sum of squares that coefficients of the first columns leave of the target.
    pub(crate) fn left(&self, coefficients: &[f64]) -> f64 {
        let weights =
            DVector::from_iterator(coefficients.len() + 1, std::iter::once(-1.0).chain(coefficients.iter().copied()));
        weights.dot(&(self.sums.view((0, 0), (weights.len(), weights.len())) * &weights)).max(0.0)
    }

    /// Inner products of the columns with what coefficients leave of the target.
    pub(crate) fn scores(&self, coefficients: &[f64]) -> DVector<f64> {
        let count = self.columns();
        self.sums.view((1, 0), (count, 1))
            - self.sums.view((1, 1), (count, count)) * DVector::from_column_slice(coefficients)
    }

    /// Inner product of two columns.
    pub(crate) fn product(&self, one: usize, other: usize) -> f64 {
        self.sums[(one + 1, other + 1)]
    }

    /// Coefficients of all columns, of either sign.
    pub(crate) fn solve(&self) -> Solution {
        self.solve_with(Collinear::LeftOut, &[], |_| None)
    }

    /// Coefficients of all columns, collinear ones held small; those marked stay at or above zero, what is not listed is free.
    pub(crate) fn solve_held(&self, nonnegative: &[bool]) -> Solution {
        self.solve_with(Collinear::HeldSmall, nonnegative, |_| None)
    }

    /// Coefficients of all columns; those marked in `nonnegative` stay at or above zero, what is not listed there is free.
    ///
    /// `correct` gives the columns' products with what coefficients leave of the target, and the length of that, where there
    /// are rows to form them from: they win back the digits that the Gram matrix costs.
    pub(crate) fn solve_with(
        &self,
        collinear: Collinear,
        nonnegative: &[bool],
        mut correct: impl FnMut(&[f64]) -> Option<(Vec<f64>, f64)>,
    ) -> Solution {
        let count = self.columns();
        let scales: Vec<f64> = (0..count).map(|column| self.square(column).sqrt()).collect();
        let nonnegative = |column: usize| nonnegative.get(column).copied().unwrap_or(false);
        let mut gram =
            DMatrix::from_fn(count, count, |row, column| self.product(row, column) / (scales[row] * scales[column]));
        let left_out = match collinear {
            Collinear::LeftOut => find_collinear(&gram, &scales),
            Collinear::HeldSmall => {
                (0..count).for_each(|at| gram[(at, at)] += if nonnegative(at) { FIRM } else { HELD });
                scales.iter().map(|scale| !is_length(*scale)).collect()
            }
        };
        let mut at_zero = vec![false; count];
        loop {
            let active: Vec<usize> = (0..count).filter(|index| !left_out[*index] && !at_zero[*index]).collect();
            let (coefficients, inverse) = self.solve_active(&gram, &scales, &active, &mut correct);
            let scaled = |index: &usize| coefficients[*index] * scales[*index];
            let negative = active.iter().filter(|index| nonnegative(**index) && coefficients[**index] < 0.0);
            match negative.min_by(|a, b| scaled(a).total_cmp(&scaled(b))) {
                Some(worst) => at_zero[*worst] = true,
                None => return Solution { coefficients, inverse, collinear: left_out, at_zero },
            }
        }
    }

    fn solve_active(
        &self,
        gram: &DMatrix<f64>,
        scales: &[f64],
        active: &[usize],
        correct: &mut impl FnMut(&[f64]) -> Option<(Vec<f64>, f64)>,
    ) -> (Vec<f64>, DMatrix<f64>) {
        let count = scales.len();
        let (mut coefficients, mut inverse) = (vec![0.0; count], DMatrix::zeros(count, count));
        let part = DMatrix::from_fn(active.len(), active.len(), |row, column| gram[(active[row], active[column])]);
        let Some(factor) = Cholesky::new(part) else { return (coefficients, inverse) };
        let size = self.total().sqrt();
        let (mut products, mut left) = ((0..count).map(|column| self.sums[(0, column + 1)]).collect(), size);
        for _ in 0..ROUNDS {
            let scaled = |index: &usize| {
                let products: &Vec<f64> = &products;
                products[*index] / scales[*index]
            };
            let step = factor.solve(&DVector::from_iterator(active.len(), active.iter().map(scaled)));
            if step.norm() <= (SETTLED * size).max(NEGLIGIBLE * left) {
                break;
            }
            active.iter().zip(step.iter()).for_each(|(index, step)| coefficients[*index] += step / scales[*index]);
            let Some(corrected) = correct(&coefficients) else { break };
            (products, left) = corrected;
        }
        let part = factor.inverse();
        for (row, at) in active.iter().enumerate() {
            for (column, other) in active.iter().enumerate() {
                inverse[(*at, *other)] = part[(row, column)] / (scales[*at] * scales[*other]);
            }
        }
        (coefficients, inverse)
    }
}

fn is_length(scale: f64) -> bool {
    scale > 0.0 && scale.is_finite()
}

/// Cholesky's pivots say how much of each column is new beside the earlier ones.
fn find_collinear(gram: &DMatrix<f64>, scales: &[f64]) -> Vec<bool> {
    let count = scales.len();
    let mut collinear: Vec<bool> = scales.iter().map(|scale| !is_length(*scale)).collect();
    let mut factor = DMatrix::<f64>::zeros(count, count);
    for row in 0..count {
        if collinear[row] {
            continue;
        }
        for column in (0..row).filter(|column| !collinear[*column]).collect::<Vec<_>>() {
            let sum: f64 = (0..column).map(|k| factor[(row, k)] * factor[(column, k)]).sum();
            factor[(row, column)] = (gram[(row, column)] - sum) / factor[(column, column)];
        }
        let left = gram[(row, row)] - (0..row).map(|k| factor[(row, k)].powi(2)).sum::<f64>();
        if left > COLLINEAR {
            factor[(row, row)] = left.sqrt();
        } else {
            collinear[row] = true;
            (0..row).for_each(|k| factor[(row, k)] = 0.0);
        }
    }
    collinear
}
