//! How well a number is known: quantiles, and the covariance of estimates from correlated residuals.

pub(crate) mod leverage;
pub(crate) mod long_run;
pub mod statistics;
