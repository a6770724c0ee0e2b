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
