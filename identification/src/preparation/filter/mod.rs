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

/// An input that is not empty with `pad` samples more at each end, by point reflection.
fn extended(input: &[f64], pad: usize) -> Vec<f64> {
    let last = input.len() - 1;
    let before = input[1..=pad].iter().rev().map(|value| 2.0 * input[0] - value);
    let after = input[last - pad..last].iter().rev().map(|value| 2.0 * input[last] - value);
    before.chain(input.iter().copied()).chain(after).collect()
}
