//! From rows to coefficients: linear least squares with bounds and robust covariance, the few searched parameters by Gauss–Newton, curves
//! measured point by point, and whether columns predict what they were not fitted to.

pub(crate) mod block_sums;
pub(crate) mod characteristic;
pub(crate) mod gram;
pub(crate) mod least_squares;
pub(crate) mod problem;
pub(crate) mod refiner;
