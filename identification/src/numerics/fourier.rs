//! Transforms, planned once per thread.

use std::cell::RefCell;
use std::f64::consts::PI;
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

/// The transform of values through Hann's window, lengthened by zeros to `length`; `None` for a length that cannot be transformed.
pub(crate) fn through_hann(values: impl ExactSizeIterator<Item = f64>, length: usize) -> Option<Vec<Complex<f64>>> {
    let count = values.len() as f64;
    let transform = forward(length);
    let mut windowed = transform.make_input_vec();
    for (index, (slot, value)) in windowed.iter_mut().zip(values).enumerate() {
        *slot = value * (PI * (index as f64 + 0.5) / count).sin().powi(2);
    }
    let mut lines = transform.make_output_vec();
    transform.process(&mut windowed, &mut lines).ok()?;
    Some(lines)
}

/// A linear filter for evenly spaced values, which count as zero beyond their ends.
#[derive(Clone, Debug)]
pub(crate) struct Response {
    count: usize,
    /// The complex gain at each line of the transform, divided by the transform's length.
    lines: Arc<[Complex<f64>]>,
}

impl Response {
    /// A filter for `count` values; `response` is the complex gain at a frequency in cycles per value.
    pub(crate) fn new(count: usize, response: &dyn Fn(f64) -> Complex<f64>) -> Self {
        let length = (count + 1).next_power_of_two();
        let scale = 1.0 / length as f64;
        Self { count, lines: (0..=length / 2).map(|index| scale * response(index as f64 * scale)).collect() }
    }

    /// The filtered values.
    pub(crate) fn of(&self, mut values: Vec<f64>) -> Vec<f64> {
        let length = 2 * (self.lines.len() - 1);
        let forward = forward(length);
        let back = PLANNER.with_borrow_mut(|planner| planner.plan_fft_inverse(length));
        values.resize(length, 0.0);
        let (mut lines, mut output) = (forward.make_output_vec(), back.make_output_vec());
        if forward.process(&mut values, &mut lines).is_ok() {
            lines.iter_mut().zip(&*self.lines).for_each(|(line, response)| *line *= response);
            // The mean and the last line are real.
            for end in [0, length / 2] {
                lines[end].im = 0.0;
            }
            if back.process(&mut lines, &mut output).is_err() {
                output.fill(0.0);
            }
        }
        output.truncate(self.count);
        output
    }
}
