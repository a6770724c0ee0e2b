//! How uncertain coefficients are whose residuals are correlated, of varying size, and smaller than the errors by what the fit
//! took.
//!
//! Takes a solved [`LeastSquares`](crate::regression::LeastSquares) and its columns; gives covariances and the degrees of freedom
//! with which they are known ([`RobustCovariance`]).

mod leverage;
mod long_run;
mod robust;

pub(crate) use robust::RobustCovariance;
