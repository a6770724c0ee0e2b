//! From rows to coefficients: linear least squares with bounds, their covariance from correlated residuals, the few searched parameters
//! by Gauss–Newton, curves measured point by point, and whether columns predict what they were not fitted to.

pub(crate) mod block_sums;
pub(crate) mod characteristic;
pub(crate) mod gram;
pub(crate) mod least_squares;
pub(crate) mod leverage;
pub(crate) mod long_run;
pub(crate) mod problem;
pub(crate) mod refiner;
