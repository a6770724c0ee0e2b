//! Transforms, planned once per thread.

use std::cell::RefCell;
use std::sync::Arc;

use realfft::num_complex::Complex;
use realfft::{RealFftPlanner, RealToComplex};

thread_local! {
    static PLANNER: RefCell<RealFftPlanner<f64>> = RefCell::new(RealFftPlanner::new());
}

/// The forward transform of `length` real numbers.
pub(crate) fn forward(length: usize) -> Arc<dyn RealToComplex<f64>> {
    PLANNER.with_borrow_mut(|planner| planner.plan_fft_forward(length))
}

/// Evenly spaced values through a response to a number of cycles from one value to the next; they are nothing beyond their ends.
#[allow(clippy::cast_precision_loss, reason = "a number of values")]
pub(crate) fn through(values: &[f64], response: impl Fn(f64) -> Complex<f64>) -> Vec<f64> {
    let length = (values.len() + 1).next_power_of_two();
    let forward = forward(length);
    let back = PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(length));
    let (mut input, mut lines) = (values.to_vec(), forward.make_output_vec());
    input.resize(length, 0.0);
    let mut output = back.make_output_vec();
    if forward.process(&mut input, &mut lines).is_ok() {
        let scale = 1.0 / length as f64;
        lines.iter_mut().enumerate().for_each(|(index, line)| *line *= scale * response(index as f64 * scale));
        // The mean and the last line are real.
        for end in [0, length / 2] {
            lines[end].im = 0.0;
        }
        if back.process(&mut lines, &mut output).is_err() {
            output.fill(0.0);
        }
    }
    output.truncate(values.len());
    output
}
