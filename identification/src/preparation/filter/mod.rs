//! Digital filters: design, causal and zero-phase use.
//!
//! Designs follow the textbook way from the analogue prototype over the bilinear transform to
//! second-order sections, with the conventions of `scipy.signal`, against which they are tested.

mod design;
mod fir;
mod sections;

pub use design::{butterworth_low_pass, chebyshev1_low_pass, chebyshev2_low_pass};
pub use fir::Fir;
pub use sections::Sections;

/// A Butterworth low-pass run both ways.
pub(crate) fn low_pass(order: usize, edge_hz: f64, rate_hz: f64, signal: &[f64]) -> Vec<f64> {
    both_ways(butterworth_low_pass(order, edge_hz, rate_hz), signal)
}

/// The signal through a filter run both ways; as it is where there is no such filter.
pub(crate) fn both_ways(filter: Option<Sections>, signal: &[f64]) -> Vec<f64> {
    filter.map_or_else(|| signal.to_vec(), |sections| sections.filter_zero_phase(signal))
}

/// An input that is not empty with `pad` samples more at each end, by point reflection.
fn extended(input: &[f64], pad: usize) -> Vec<f64> {
    let last = input.len() - 1;
    let before = input[1..=pad].iter().rev().map(|value| 2.0 * input[0] - value);
    let after = input[last - pad..last].iter().rev().map(|value| 2.0 * input[last] - value);
    before.chain(input.iter().copied()).chain(after).collect()
}
