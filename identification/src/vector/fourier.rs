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

/// Evenly spaced values through a response, which is given for every line: the line at `index` makes so many cycles over
/// all values.
pub(crate) fn through(values: &[f64], response: impl Fn(usize) -> Complex<f64>) -> Vec<f64> {
    let forward = forward(values.len());
    let back = PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(values.len()));
    let (mut input, mut lines) = (values.to_vec(), forward.make_output_vec());
    let mut output = back.make_output_vec();
    if forward.process(&mut input, &mut lines).is_err() {
        return output;
    }
    lines.iter_mut().enumerate().for_each(|(index, line)| *line *= response(index));
    // The mean and, of an even number, the last line are real.
    if let Some(line) = lines.first_mut() {
        line.im = 0.0;
    }
    if let Some(line) = lines.last_mut().filter(|_| values.len().is_multiple_of(2)) {
        line.im = 0.0;
    }
    if back.process(&mut lines, &mut output).is_ok() {
        output.iter_mut().for_each(|value| *value /= values.len() as f64);
    }
    output
}
