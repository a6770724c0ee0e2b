//! Digital filters: design, causal and zero-phase use.
//!
//! Designs follow the textbook way from the analogue prototype over the bilinear transform to
//! second-order sections, with the conventions of `scipy.signal`, against which they are tested.

mod design;
mod fir;
mod sections;

pub use design::{FilterError, butterworth_low_pass, chebyshev1_low_pass, chebyshev2_low_pass};
pub use fir::Fir;
pub use sections::{SectionState, Sections};

/// Rows are kept at this multiple of the edge of the low-pass that they passed.
pub(crate) const ROWS_PER_EDGE: f64 = 2.5;

/// Every how many samples a row is kept behind a low-pass.
pub(crate) fn rows_step(edge_hz: f64, rate_hz: f64) -> usize {
    ((rate_hz / (ROWS_PER_EDGE * edge_hz)) as usize).max(1)
}

/// A Butterworth low-pass run both ways; the signal as it is where the sample rate does not carry the edge.
pub(crate) fn low_pass(order: usize, edge_hz: f64, rate_hz: f64, signal: &[f64]) -> Vec<f64> {
    butterworth_low_pass(order, edge_hz, rate_hz)
        .map_or_else(|_| signal.to_vec(), |sections| sections.filter_zero_phase(signal))
}
