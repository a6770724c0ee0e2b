//! Filters and differences of neighbouring samples.

use super::dot_inline;

/// Every `step`-th sample of a filtered signal: `output[i] = Σ taps[j] · input[i · step + j]`.
///
/// With the input sorted by its place modulo `step`, neighbouring outputs take neighbouring inputs: whole vectors of
/// outputs are summed at once.
pub(crate) fn decimate(input: &[f64], taps: &[f64], step: usize, output: &mut [f64]) {
    /// Outputs that are summed side by side: enough that no addition waits for the one before.
    const OUTPUTS: usize = 32;
    let length = if step == 1 { input.len() } else { output.len() + taps.len().div_ceil(step) };
    let mut sorted = vec![0.0; if step == 1 { 0 } else { length * step }];
    let places: Vec<(usize, f64)> =
        taps.iter().enumerate().map(|(index, tap)| ((index % step) * length + index / step, *tap)).collect();
    widest!({
        match step {
            1 => {}
            // The step of the widest band: known here, so that whole vectors are sorted at once.
            4 => sort_by_phase::<4>(input, length, &mut sorted),
            _ => {
                for (phase, sorted) in sorted.chunks_exact_mut(length).enumerate() {
                    let values = input.iter().skip(phase).step_by(step);
                    sorted.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
                }
            }
        }
        let phases = if step == 1 { input } else { &sorted };
        let (blocks, rest) = output.as_chunks_mut::<OUTPUTS>();
        for (block, start) in blocks.iter_mut().zip((0..).step_by(OUTPUTS)) {
            let mut sums = [0.0; OUTPUTS];
            for (place, tap) in &places {
                let place = place + start;
                for (sum, value) in sums.iter_mut().zip(&phases[place..place + OUTPUTS]) {
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

/// Values by their place modulo `STEP`, `length` of each.
#[inline(always)]
fn sort_by_phase<const STEP: usize>(input: &[f64], length: usize, sorted: &mut [f64]) {
    let (whole, rest) = input.as_chunks::<STEP>();
    let count = whole.len().min(length);
    for (phase, sorted) in sorted.chunks_exact_mut(length).enumerate() {
        for (slot, values) in sorted[..count].iter_mut().zip(&whole[..count]) {
            *slot = values[phase];
        }
        if let (Some(slot), Some(value)) = (sorted.get_mut(whole.len()), rest.get(phase)) {
            *slot = *value;
        }
    }
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
        for (slot, near) in output.iter_mut().zip(signal.array_windows::<9>()) {
            *slot = (0..4).map(|place| weights[place] * (near[5 + place] - near[3 - place])).sum();
        }
    });
}

/// How many fourth differences lie below a limit.
pub(crate) fn small_fourth_differences(signal: &[f64], limit: f64) -> usize {
    widest!({
        let small = |w: &[f64; 5]| u64::from((w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs() < limit);
        signal.array_windows().map(small).sum::<u64>() as usize
    })
}
