//! A model as a hypothesis about a capture, and its fit: linear where it can be, with the inner body simulated where it must be.

pub(crate) mod bound;
pub(crate) mod columns;
mod free_values;
pub(crate) mod intervals;
mod kept;
mod lobes;
pub(crate) mod nonlinear;
pub(crate) mod residuals;
pub(crate) mod separable;
pub(crate) mod sticking;
pub(crate) mod structure;
pub(crate) mod twist;
pub(crate) mod undetermined;
pub(crate) mod unequal;
