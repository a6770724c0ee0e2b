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

/// So many evenly spaced values through a response to a number of cycles from one value to the next; they are nothing beyond
/// their ends.
#[allow(clippy::cast_precision_loss, reason = "a number of values")]
pub(crate) fn through(count: usize, response: &dyn Fn(f64) -> Complex<f64>) -> impl Fn(Vec<f64>) -> Vec<f64> + use<> {
    let length = (count + 1).next_power_of_two();
    let forward = forward(length);
    let back = PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(length));
    let scale = 1.0 / length as f64;
    let responses: Vec<Complex<f64>> =
        (0..forward.complex_len()).map(|index| scale * response(index as f64 * scale)).collect();
    move |mut values| {
        values.resize(length, 0.0);
        let (mut lines, mut output) = (forward.make_output_vec(), back.make_output_vec());
        if forward.process(&mut values, &mut lines).is_ok() {
            lines.iter_mut().zip(&responses).for_each(|(line, response)| *line *= response);
            // The mean and the last line are real.
            for end in [0, length / 2] {
                lines[end].im = 0.0;
            }
            if back.process(&mut lines, &mut output).is_err() {
                output.fill(0.0);
            }
        }
        output.truncate(count);
        output
    }
}
