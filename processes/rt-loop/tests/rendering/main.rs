//! A rendered knob in a simulated hand.

#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs, reason = "a test may stop at a failure")]

mod firmness;
mod held_knob;
mod numbers;
mod passivity;
mod random_knob;
mod sticking;
mod swaps;
