//! The few loops that take the time, compiled for the widest vectors that the processor has.
//!
//! Nothing is assumed of the processor: `pulp` looks once and picks among copies of each loop.

/// Runs a loop in the copy of it that is compiled for the widest vectors.
///
/// All that it calls must be `#[inline(always)]`: what is not inlined is compiled for any processor.
macro_rules! widest {
    ($body:expr) => {
        pulp::Arch::new().dispatch($crate::numerics::vector::Body(
            #[inline(always)]
            || $body,
        ))
    };
}

mod angles;
mod checks;
mod filters;
mod windows;

use std::ops::Deref;

use nalgebra::DMatrix;
use pulp::NullaryFnOnce;

pub(crate) use angles::{share_out, share_out_together, sines};
pub(crate) use checks::{all_finite, extent, extent_where, rises, smallest_step};
pub(crate) use filters::{decimate, differences, small_fourth_differences, spread};
pub(crate) use windows::{grouped_products, triangle};

/// Rows that are looked at together: a dozen columns of them stay in the first-level cache.
const BLOCK: usize = 512;
/// Share of its square that a column must have beside the ones before to have a direction of its own.
const DEPENDENT: f64 = 1e-8;
/// Independent partial sums.
const LANES: usize = 16;

/// The body of a loop. Called as a plain `FnOnce` it would hide behind a function of the compiler's that is not inlined.
struct Body<F>(F);

impl<R, F: FnMut() -> R> NullaryFnOnce for Body<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}

/// Inner product of two columns of one length.
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    widest!(dot_inline(left, right))
}

#[inline(always)]
fn dot_inline(left: &[f64], right: &[f64]) -> f64 {
    let length = left.len().min(right.len());
    let (left, right) = (left[..length].chunks_exact(LANES), right[..length].chunks_exact(LANES));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in left.zip(right) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Inner products of the columns from `from` on with all up to themselves, written to both triangles of `products`.
pub(crate) fn products<C: Deref<Target = [f64]>>(columns: &[C], from: usize, products: &mut DMatrix<f64>) {
    for row in from..columns.len() {
        for column in 0..=row {
            products[(row, column)] = 0.0;
        }
    }
    let rows = columns.first().map_or(0, |column| column.len());
    widest!({
        for start in (0..rows).step_by(BLOCK) {
            let block = start..(start + BLOCK).min(rows);
            for row in from..columns.len() {
                for column in 0..=row {
                    products[(row, column)] +=
                        dot_inline(&columns[row][block.clone()], &columns[column][block.clone()]);
                }
            }
        }
    });
    for row in from..columns.len() {
        for column in 0..row {
            products[(column, row)] = products[(row, column)];
        }
    }
}

/// Inner products of all columns.
pub(crate) fn gram<C: Deref<Target = [f64]>>(columns: &[C]) -> DMatrix<f64> {
    let mut gram = DMatrix::zeros(columns.len(), columns.len());
    products(columns, 0, &mut gram);
    gram
}

/// Writes target − Σ coefficient · column to `residual` and returns its inner product with every column, in one pass.
pub(crate) fn residual<C: Deref<Target = [f64]>>(
    columns: &[C],
    coefficients: &[f64],
    target: &[f64],
    residual: &mut [f64],
) -> Vec<f64> {
    let mut products = vec![0.0; columns.len()];
    let rows = target.len();
    widest!({
        for start in (0..rows).step_by(BLOCK) {
            let block = start..(start + BLOCK).min(rows);
            let left = &mut residual[block.clone()];
            left.copy_from_slice(&target[block.clone()]);
            for (column, coefficient) in columns.iter().zip(coefficients).filter(|(_, c)| **c != 0.0) {
                for (left, value) in left.iter_mut().zip(&column[block.clone()]) {
                    *left -= coefficient * value;
                }
            }
            for (product, column) in products.iter_mut().zip(columns) {
                *product += dot_inline(left, &column[block.clone()]);
            }
        }
    });
    products
}

/// Multiplies a column by another, row by row.
pub(crate) fn multiply_by(column: &mut [f64], factor: &[f64]) {
    widest!(column.iter_mut().zip(factor).for_each(|(value, factor)| *value *= factor));
}

/// Takes a multiple of another column off a column.
pub(crate) fn subtract(column: &mut [f64], factor: f64, other: &[f64]) {
    widest!(column.iter_mut().zip(other).for_each(|(value, other)| *value -= factor * other));
}

/// Sum of a column.
pub(crate) fn sum(values: &[f64]) -> f64 {
    widest!({
        let (chunks, rest) = values.as_chunks::<LANES>();
        let mut sums = [0.0; LANES];
        for chunk in chunks {
            sums.iter_mut().zip(chunk).for_each(|(sum, value)| *sum += value);
        }
        sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
    })
}

/// `xᵀ·matrix·x` for the symmetric `matrix` and every row x of the columns.
pub(crate) fn quadratic_form<C: Deref<Target = [f64]>>(columns: &[C], matrix: &DMatrix<f64>, output: &mut [f64]) {
    let rows = output.len();
    output.fill(0.0);
    widest!({
        let mut inner = [0.0; BLOCK];
        for start in (0..rows).step_by(BLOCK) {
            let block = start..(start + BLOCK).min(rows);
            let inner = &mut inner[..block.len()];
            for (index, column) in columns.iter().enumerate() {
                inner.fill(0.0);
                for (other, right) in columns[..=index].iter().enumerate() {
                    let factor = if other == index { 1.0 } else { 2.0 } * matrix[(index, other)];
                    for (sum, value) in inner.iter_mut().zip(&right[block.clone()]) {
                        *sum += factor * value;
                    }
                }
                for ((slot, sum), value) in output[block.clone()].iter_mut().zip(&*inner).zip(&column[block.clone()]) {
                    *slot += sum * value;
                }
            }
        }
    });
}

/// Columns of Coulomb and viscous friction, of the negative and the positive direction each, as the effect defines them.
pub(crate) fn friction(velocity: &[f64], [coulomb_negative, coulomb_positive, negative, positive]: [&mut [f64]; 4]) {
    widest!({
        let coulomb = coulomb_negative.iter_mut().zip(coulomb_positive.iter_mut());
        let viscous = negative.iter_mut().zip(positive.iter_mut());
        for ((velocity, coulomb), viscous) in velocity.iter().zip(coulomb).zip(viscous) {
            *coulomb.0 = if *velocity < 0.0 { -1.0 } else { 0.0 };
            *coulomb.1 = if *velocity > 0.0 { 1.0 } else { 0.0 };
            *viscous.0 = if *velocity < 0.0 { *velocity } else { 0.0 };
            *viscous.1 = if *velocity > 0.0 { *velocity } else { 0.0 };
        }
    });
}

/// Takes the directions of orthonormal columns out of another one.
pub(crate) fn take_out(basis: &[Vec<f64>], column: &mut [f64]) {
    for known in basis {
        let share = dot(known, column);
        subtract(column, share, known);
    }
}

/// An orthonormal basis of columns (Gram and Schmidt), without those that depend on the ones before.
pub(crate) fn orthonormal<C: AsRef<[f64]>>(columns: &[C]) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let mut left = column.as_ref().to_vec();
        let before = dot(&left, &left);
        take_out(&basis, &mut left);
        let after = dot(&left, &left);
        if after > DEPENDENT * before {
            left.iter_mut().for_each(|value| *value /= after.sqrt());
            basis.push(left);
        }
    }
    basis
}
