//! Filters and differences of neighbouring samples.

use super::dot_inline;

/// Outputs that are summed side by side: enough that no addition waits for the one before.
const OUTPUTS: usize = 32;

/// Every `step`-th sample of a filtered signal: `output[i] = Σ taps[j] · input[i · step + j]`.
///
/// In the input's polyphase components neighbouring outputs take neighbouring values: whole vectors of outputs are summed at
/// once.
pub(crate) fn decimate(input: &[f64], taps: &[f64], step: usize, output: &mut [f64]) {
    let length = output.len() + taps.len().div_ceil(step);
    let mut phases = vec![0.0; step * length];
    widest!({
        for (phase, component) in phases.chunks_exact_mut(length).enumerate() {
            let values = input.iter().skip(phase).step_by(step);
            component.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
        }
        let (blocks, rest) = output.as_chunks_mut::<OUTPUTS>();
        for (block, start) in blocks.iter_mut().zip((0..).step_by(OUTPUTS)) {
            let mut sums = [0.0; OUTPUTS];
            for (index, tap) in taps.iter().enumerate() {
                let first = (index % step) * length + index / step + start;
                for (sum, value) in sums.iter_mut().zip(&phases[first..first + OUTPUTS]) {
                    *sum += tap * value;
                }
            }
            *block = sums;
        }
        let done = blocks.len() * OUTPUTS;
        for (slot, window) in rest.iter_mut().zip(input.windows(taps.len()).step_by(step).skip(done)) {
            *slot = dot_inline(window, taps);
        }
    });
}

/// The adjoint of [`decimate`]: adds `kept[i] · taps[j]` to `output[i · step + j]`.
pub(crate) fn spread(kept: &[f64], taps: &[f64], step: usize, output: &mut [f64]) {
    widest!({
        for (index, value) in kept.iter().enumerate() {
            for (slot, tap) in output[index * step..index * step + taps.len()].iter_mut().zip(taps) {
                *slot += value * tap;
            }
        }
    });
}

/// Differences across one to four samples on either side, weighted and summed; none for the four samples at each end.
pub(crate) fn differences(signal: &[f64], weights: [f64; 4], output: &mut [f64]) {
    widest!({
        for (slot, near) in output.iter_mut().zip(signal.array_windows()) {
            *slot = difference(near, weights);
        }
    });
}

/// The same at one sample, from those around it.
#[inline(always)]
pub(crate) fn difference(near: &[f64; 9], weights: [f64; 4]) -> f64 {
    (0..4).map(|place| weights[place] * (near[5 + place] - near[3 - place])).sum()
}

/// How many fourth differences lie below a limit.
pub(crate) fn small_fourth_differences(signal: &[f64], limit: f64) -> usize {
    widest!({
        let small = |w: &[f64; 5]| u64::from((w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs() < limit);
        signal.array_windows().map(small).sum::<u64>() as usize
    })
}
