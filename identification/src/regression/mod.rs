//! Least squares from inner products, and the parameters that make it nonlinear.
//!
//! Takes rows of a target and of columns. Gives coefficients with the inverse of their Gram matrix ([`Gram`]), what they leave row by row
//! ([`LeastSquares`]), what stretches of the rows say about them ([`Blocks`]), and the few parameters on which columns themselves
//! depend ([`Problem`], by [`refine`]), with the reason why their search ended.
//!
//! Why not `varpro` or `levenberg-marquardt`: coefficients here stay at or above zero, the sensors' noise is taken off the
//! normal equations, and where a step is a simulation, derivatives are updated instead of taken anew. `varpro` 0.14 factors
//! all rows where a Gram matrix has summed them: one period refined over 7500 rows and seven columns took it 21.6 ms, plain
//! normal equations with nalgebra 2.9 ms (least of 15 runs each, on a loaded machine).

mod blocks;
mod gram;
mod least_squares;
mod problem;
mod refine;

pub(crate) use blocks::Blocks;
pub(crate) use gram::{Gram, Solution};
pub(crate) use least_squares::{LeastSquares, residual};
pub(crate) use problem::{Column, Problem};
pub(crate) use refine::{Damping, Refined, projected, refine};
