//! The few loops that take the time, compiled for the widest vectors that the processor has.
//!
//! Nothing is assumed of the processor: `pulp` looks once and picks among copies of each loop.

use std::f64::consts::FRAC_2_PI;
use std::ops::Deref;

use nalgebra::DMatrix;
use pulp::{Arch, NullaryFnOnce};

/// Rows that are looked at together: a dozen columns of them stay in the first-level cache.
const BLOCK: usize = 512;
/// Independent partial sums.
const LANES: usize = 16;
/// Largest argument that the reduction below takes without losing digits; larger ones go the slow way.
const LARGEST_ARGUMENT: f64 = 1e6;

/// Runs a loop in the copy of it that is compiled for the widest vectors.
///
/// The loop and all that it calls must be `#[inline(always)]`: what is not inlined is compiled for any processor.
#[inline(always)]
fn widest<R>(body: impl FnMut() -> R) -> R {
    Arch::new().dispatch(Body(body))
}

/// The body of a loop. Called as a plain `FnOnce` it would hide behind a function of the compiler's that is not inlined.
struct Body<F>(F);

impl<R, F: FnMut() -> R> NullaryFnOnce for Body<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}

/// Inner product of two columns of one length.
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || dot_inline(left, right),
    )
}

#[inline(always)]
fn dot_inline(left: &[f64], right: &[f64]) -> f64 {
    let length = left.len().min(right.len());
    let (left, right) = (left[..length].chunks_exact(LANES), right[..length].chunks_exact(LANES));
    let rest: f64 = left.remainder().iter().zip(right.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in left.zip(right) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

/// Inner products of the columns from `from` on with all up to themselves, written to both triangles of `products`.
pub(crate) fn products<C: Deref<Target = [f64]>>(columns: &[C], from: usize, products: &mut DMatrix<f64>) {
    for row in from..columns.len() {
        for column in 0..=row {
            products[(row, column)] = 0.0;
        }
    }
    let rows = columns.first().map_or(0, |column| column.len());
    widest(
        #[inline(always)]
        || {
            for start in (0..rows).step_by(BLOCK) {
                let block = start..(start + BLOCK).min(rows);
                for row in from..columns.len() {
                    for column in 0..=row {
                        products[(row, column)] +=
                            dot_inline(&columns[row][block.clone()], &columns[column][block.clone()]);
                    }
                }
            }
        },
    );
    for row in from..columns.len() {
        for column in 0..row {
            products[(column, row)] = products[(row, column)];
        }
    }
}

/// Target minus the columns' sum, and its inner product with every column, in one pass.
pub(crate) fn residual<C: Deref<Target = [f64]>>(
    columns: &[C],
    coefficients: &[f64],
    target: &[f64],
    residual: &mut [f64],
) -> Vec<f64> {
    let mut products = vec![0.0; columns.len()];
    let rows = target.len();
    widest(
        #[inline(always)]
        || {
            for start in (0..rows).step_by(BLOCK) {
                let block = start..(start + BLOCK).min(rows);
                let left = &mut residual[block.clone()];
                left.copy_from_slice(&target[block.clone()]);
                for (column, coefficient) in columns.iter().zip(coefficients).filter(|(_, c)| **c != 0.0) {
                    for (left, value) in left.iter_mut().zip(&column[block.clone()]) {
                        *left -= coefficient * value;
                    }
                }
                for (product, column) in products.iter_mut().zip(columns) {
                    *product += dot_inline(left, &column[block.clone()]);
                }
            }
        },
    );
    products
}

/// Multiplies a column by another, row by row.
pub(crate) fn multiply_by(column: &mut [f64], factor: &[f64]) {
    widest(
        #[inline(always)]
        || column.iter_mut().zip(factor).for_each(|(value, factor)| *value *= factor),
    );
}

/// Sum of a column.
pub(crate) fn sum(values: &[f64]) -> f64 {
    widest(
        #[inline(always)]
        || {
            let (chunks, rest) = values.as_chunks::<LANES>();
            let mut sums = [0.0; LANES];
            for chunk in chunks {
                sums.iter_mut().zip(chunk).for_each(|(sum, value)| *sum += value);
            }
            sums.iter().sum::<f64>() + rest.iter().sum::<f64>()
        },
    )
}

/// Row by row product of two columns.
pub(crate) fn multiply(left: &[f64], right: &[f64]) -> Vec<f64> {
    left.iter().zip(right).map(|(left, right)| left * right).collect()
}

/// `xᵀ·matrix·x` for the symmetric `matrix` and every row x of the columns.
pub(crate) fn quadratic_form<C: Deref<Target = [f64]>>(columns: &[C], matrix: &DMatrix<f64>, output: &mut [f64]) {
    let rows = output.len();
    output.fill(0.0);
    widest(
        #[inline(always)]
        || {
            let mut inner = [0.0; BLOCK];
            for start in (0..rows).step_by(BLOCK) {
                let block = start..(start + BLOCK).min(rows);
                let inner = &mut inner[..block.len()];
                for (index, column) in columns.iter().enumerate() {
                    inner.fill(0.0);
                    for (other, right) in columns[..=index].iter().enumerate() {
                        let factor = if other == index { 1.0 } else { 2.0 } * matrix[(index, other)];
                        for (sum, value) in inner.iter_mut().zip(&right[block.clone()]) {
                            *sum += factor * value;
                        }
                    }
                    for ((slot, sum), value) in
                        output[block.clone()].iter_mut().zip(&*inner).zip(&column[block.clone()])
                    {
                        *slot += sum * value;
                    }
                }
            }
        },
    );
}

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
    widest(
        #[inline(always)]
        || {
            match step {
                1 => {}
                // The step of the widest band: known here, so that whole vectors are sorted at once.
                4 => sort_by_phase(input.as_chunks::<4>().0, length, &mut sorted),
                _ => {
                    for (phase, sorted) in sorted.chunks_exact_mut(length).enumerate() {
                        let values = input.iter().skip(phase).step_by(step);
                        sorted.iter_mut().zip(values).for_each(|(slot, value)| *slot = *value);
                    }
                }
            }
            if step == 4 {
                let (whole, rest) = input.as_chunks::<4>();
                if whole.len() < length {
                    rest.iter().enumerate().for_each(|(phase, value)| sorted[phase * length + whole.len()] = *value);
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
        },
    );
}

/// Values by their place modulo `STEP`, `length` of each.
#[inline(always)]
fn sort_by_phase<const STEP: usize>(input: &[[f64; STEP]], length: usize, sorted: &mut [f64]) {
    let length_in = input.len().min(length);
    for (phase, sorted) in sorted.chunks_exact_mut(length).enumerate().take(STEP) {
        for (slot, values) in sorted[..length_in].iter_mut().zip(&input[..length_in]) {
            *slot = values[phase];
        }
    }
}

/// The adjoint of [`decimate`]: adds `kept[i] · taps[j]` to `output[i · step + j]`.
pub(crate) fn spread(kept: &[f64], taps: &[f64], step: usize, output: &mut [f64]) {
    widest(
        #[inline(always)]
        || {
            for (index, value) in kept.iter().enumerate() {
                for (slot, tap) in output[index * step..index * step + taps.len()].iter_mut().zip(taps) {
                    *slot += value * tap;
                }
            }
        },
    );
}

/// Shares every value out among four bins by a cubic spline; its place lies between the second and the third of them.
///
/// Neighbouring samples mostly share their bins, and an addition would wait for the one before it to be stored: samples
/// from two halves take turns.
pub(crate) fn share_out(values: &[f64], angles: &[f64], offset_rad: f64, bin_rad: f64, bins: &mut [f64]) {
    let per_bin = 1.0 / bin_rad;
    let Some(last) = bins.len().checked_sub(4) else { return };
    let length = values.len().min(angles.len());
    let half = length.div_ceil(2);
    let mut shares = [Shares::EMPTY; 2];
    widest(
        #[inline(always)]
        || {
            for start in (0..half).step_by(BLOCK) {
                for (shares, first) in shares.iter_mut().zip([start, half + start]) {
                    let end = (start + BLOCK).min(half) - start + first;
                    let range = first.min(length)..end.min(length);
                    shares.of(&values[range.clone()], &angles[range], offset_rad, per_bin);
                }
                for place in 0..BLOCK {
                    for shares in &shares {
                        let first = (shares.first[place] as usize).min(last);
                        for (bin, share) in bins[first..first + 4].iter_mut().zip(&shares.share) {
                            *bin += share[place];
                        }
                    }
                }
            }
        },
    );
}

/// What a block of values gives to four bins each.
#[derive(Clone, Copy)]
struct Shares {
    first: [u32; BLOCK],
    share: [[f64; BLOCK]; 4],
}

impl Shares {
    const EMPTY: Self = Self { first: [0; BLOCK], share: [[0.0; BLOCK]; 4] };

    /// Shares of up to a block of values; nothing beyond them.
    #[inline(always)]
    fn of(&mut self, values: &[f64], angles: &[f64], offset_rad: f64, per_bin: f64) {
        let Self { first, share: [a, b, c, d] } = self;
        let count = values.len();
        let slots = first.iter_mut().zip(a.iter_mut()).zip(b.iter_mut()).zip(c.iter_mut()).zip(d.iter_mut());
        for (((((first, a), b), c), d), (value, angle)) in slots.zip(values.iter().zip(angles)) {
            let place = ((angle - offset_rad) * per_bin).max(0.0);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index of a bin")]
            let index = place as u32;
            let share = place - f64::from(index);
            let rest = 1.0 - share;
            let sixth = value / 6.0;
            *first = index;
            *a = sixth * rest * rest * rest;
            *b = sixth * (4.0 - 3.0 * share * share * (1.0 + rest));
            *c = sixth * (4.0 - 3.0 * rest * rest * (1.0 + share));
            *d = sixth * share * share * share;
        }
        [a, b, c, d].into_iter().for_each(|share| share[count..].fill(0.0));
    }
}

/// [`share_out`] of several columns with the same angles, side by side in every bin.
pub(crate) fn share_out_together<const COLUMNS: usize>(
    columns: &[&[f64]; COLUMNS],
    angles: &[f64],
    offset_rad: f64,
    bin_rad: f64,
    bins: &mut [[f64; COLUMNS]],
) {
    let per_bin = 1.0 / bin_rad;
    let Some(last) = bins.len().checked_sub(4) else { return };
    let ones = [1.0; BLOCK];
    let mut shares = Shares::EMPTY;
    widest(
        #[inline(always)]
        || {
            for (angles, start) in angles.chunks(BLOCK).zip((0..).step_by(BLOCK)) {
                shares.of(&ones[..angles.len()], angles, offset_rad, per_bin);
                for place in 0..angles.len() {
                    let values: [f64; COLUMNS] = columns.map(
                        #[inline(always)]
                        |column| column[start + place],
                    );
                    let first = (shares.first[place] as usize).min(last);
                    for (bin, share) in bins[first..first + 4].iter_mut().zip(&shares.share) {
                        for (sum, value) in bin.iter_mut().zip(&values) {
                            *sum += share[place] * value;
                        }
                    }
                }
            }
        },
    );
}

/// Columns of Coulomb and viscous friction, of the negative and the positive direction each, as the effect defines them.
pub(crate) fn friction(velocity: &[f64], [coulomb_negative, coulomb_positive, negative, positive]: [&mut [f64]; 4]) {
    widest(
        #[inline(always)]
        || {
            let coulomb = coulomb_negative.iter_mut().zip(coulomb_positive.iter_mut());
            let viscous = negative.iter_mut().zip(positive.iter_mut());
            for ((velocity, coulomb), viscous) in velocity.iter().zip(coulomb).zip(viscous) {
                *coulomb.0 = if *velocity < 0.0 { -1.0 } else { 0.0 };
                *coulomb.1 = if *velocity > 0.0 { 1.0 } else { 0.0 };
                *viscous.0 = if *velocity < 0.0 { *velocity } else { 0.0 };
                *viscous.1 = if *velocity > 0.0 { *velocity } else { 0.0 };
            }
        },
    );
}

/// Differences across one to four samples on either side, weighted and summed; none for the four samples at each end.
pub(crate) fn differences(signal: &[f64], weights: [f64; 4], output: &mut [f64]) {
    let count = output.len();
    let [a, b, c, d] = weights;
    let before: [&[f64]; 4] = [3, 2, 1, 0].map(|shift| &signal[shift..shift + count]);
    let after: [&[f64]; 4] = [5, 6, 7, 8].map(|shift| &signal[shift..shift + count]);
    let ([before_1, before_2, before_3, before_4], [after_1, after_2, after_3, after_4]) = (before, after);
    widest(
        #[inline(always)]
        || {
            let near = before_1.iter().zip(after_1).zip(before_2.iter().zip(after_2));
            let far = before_3.iter().zip(after_3).zip(before_4.iter().zip(after_4));
            for (slot, (near, far)) in output.iter_mut().zip(near.zip(far)) {
                let near = a * (near.0.1 - near.0.0) + b * (near.1.1 - near.1.0);
                *slot = near + c * (far.0.1 - far.0.0) + d * (far.1.1 - far.1.0);
            }
        },
    );
}

/// How many fourth differences lie below a limit.
pub(crate) fn small_fourth_differences(signal: &[f64], limit: f64) -> usize {
    widest(
        #[inline(always)]
        || {
            let small = |w: &[f64; 5]| u64::from((w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs() < limit);
            signal.array_windows().map(small).sum::<u64>() as usize
        },
    )
}

/// Smallest and largest value; `None` for no values.
pub(crate) fn extent(values: &[f64]) -> Option<(f64, f64)> {
    extent_of(
        values,
        values,
        #[inline(always)]
        |value, _| (value, value),
    )
}

/// Smallest and largest of the values whose weight is above zero; `None` for none.
pub(crate) fn extent_where(values: &[f64], weights: &[f64]) -> Option<(f64, f64)> {
    let none = (f64::INFINITY, f64::NEG_INFINITY);
    extent_of(
        values,
        weights,
        #[inline(always)]
        |value, weight| (if weight > 0.0 { value } else { none.0 }, if weight > 0.0 { value } else { none.1 }),
    )
}

/// The smallest difference between neighbours that differ; infinite for none.
pub(crate) fn smallest_step(values: &[f64]) -> f64 {
    let next = values.get(1..).unwrap_or_default();
    let steps = extent_of(
        &values[..next.len()],
        next,
        #[inline(always)]
        |left, right| {
            let step = (right - left).abs();
            (if step > 0.0 { step } else { f64::INFINITY }, step)
        },
    );
    steps.map_or(f64::INFINITY, |(least, _)| least)
}

/// Smallest first and largest second of what `of` makes of pairs; `None` if there is nothing between them.
#[inline(always)]
fn extent_of(left: &[f64], right: &[f64], of: impl Fn(f64, f64) -> (f64, f64)) -> Option<(f64, f64)> {
    let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
    widest(
        #[inline(always)]
        || {
            let (left, right) = (left.as_chunks::<LANES>(), right.as_chunks::<LANES>());
            for (left, right) in left.0.iter().zip(right.0) {
                for lane in 0..LANES {
                    let (lower, upper) = of(left[lane], right[lane]);
                    low[lane] = if lower < low[lane] { lower } else { low[lane] };
                    high[lane] = if upper > high[lane] { upper } else { high[lane] };
                }
            }
            for (left, right) in left.1.iter().zip(right.1) {
                let (lower, upper) = of(*left, *right);
                (low[0], high[0]) = (low[0].min(lower), high[0].max(upper));
            }
        },
    );
    let low = low.into_iter().fold(f64::INFINITY, f64::min);
    let high = high.into_iter().fold(f64::NEG_INFINITY, f64::max);
    (low <= high).then_some((low, high))
}

/// Whether all values are numbers and none is infinite.
pub(crate) fn all_finite(values: &[f64]) -> bool {
    widest(
        #[inline(always)]
        || values.iter().fold(true, |all, value| all & value.is_finite()),
    )
}

/// Whether every value lies above the one before.
pub(crate) fn rises(values: &[f64]) -> bool {
    widest(
        #[inline(always)]
        || values.iter().zip(values.iter().skip(1)).fold(true, |all, (before, after)| all & (before < after)),
    )
}

/// Sine and cosine of `wavenumber` times every angle, to a unit or two in the last place.
///
/// Cody and Waite's reduction to ±π/4 and the polynomials of fdlibm (`k_sin.c`, `k_cos.c`, Sun Microsystems 1993).
pub(crate) fn sines(angle: &[f64], wavenumber: f64, sine: &mut [f64], cosine: &mut [f64]) {
    widest(
        #[inline(always)]
        || {
            let mut too_large = 0_u64;
            for ((angle, sine), cosine) in angle.iter().zip(sine.iter_mut()).zip(cosine.iter_mut()) {
                let argument = angle * wavenumber;
                too_large |= u64::from(argument.abs() > LARGEST_ARGUMENT);
                (*sine, *cosine) = sine_cosine(argument);
            }
            if too_large != 0 {
                for ((angle, sine), cosine) in angle.iter().zip(sine.iter_mut()).zip(cosine.iter_mut()) {
                    (*sine, *cosine) = (angle * wavenumber).sin_cos();
                }
            }
        },
    );
}

#[inline(always)]
#[allow(clippy::excessive_precision, reason = "as published")]
fn sine_cosine(argument: f64) -> (f64, f64) {
    /// Adding it rounds to the nearest integer, which then stands in the lowest bits.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    const HALF_PI: [f64; 3] = [1.570_796_326_734_125_614_17, 6.077_100_506_303_966e-11, 2.022_266_248_795_950_6e-21];
    const SINE: [f64; 6] = [
        -1.666_666_666_666_663_243_48e-1,
        8.333_333_333_322_489_461_24e-3,
        -1.984_126_982_985_794_931_34e-4,
        2.755_731_370_707_006_767_89e-6,
        -2.505_076_025_340_686_341_95e-8,
        1.589_690_995_211_550_102_21e-10,
    ];
    const COSINE: [f64; 6] = [
        4.166_666_666_666_660_190_37e-2,
        -1.388_888_888_887_410_957_49e-3,
        2.480_158_728_947_672_941_78e-5,
        -2.755_731_435_139_066_330_35e-7,
        2.087_572_321_298_174_827_90e-9,
        -1.135_964_755_778_819_482_65e-11,
    ];
    let shifted = argument * FRAC_2_PI + ROUND;
    let turns = shifted - ROUND;
    let quadrant = shifted.to_bits();
    let rest = ((argument - turns * HALF_PI[0]) - turns * HALF_PI[1]) - turns * HALF_PI[2];
    let square = rest * rest;
    let polynomial =
        |c: &[f64; 6]| c[0] + square * (c[1] + square * (c[2] + square * (c[3] + square * (c[4] + square * c[5]))));
    let sine = rest + rest * square * polynomial(&SINE);
    let cosine = 1.0 - 0.5 * square + square * square * polynomial(&COSINE);
    // Odd quadrants swap both; bit 1 of the quadrant, or of the next one, is the sign.
    let odd = 0_u64.wrapping_sub(quadrant & 1);
    let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
    let swapped = (sine ^ cosine) & odd;
    let sign = |quadrant: u64| (quadrant & 2) << 62;
    (
        f64::from_bits((sine ^ swapped) ^ sign(quadrant)),
        f64::from_bits((cosine ^ swapped) ^ sign(quadrant.wrapping_add(1))),
    )
}

#[cfg(test)]
mod tests {
    use super::sines;

    #[test]
    fn sines_agree_with_the_standard_library() {
        for wavenumber in [1e-3, 1.0, 7.3, 1234.5, 3e7] {
            let angle: Vec<f64> = (-2000..2000).map(|n| f64::from(n) * 0.013).collect();
            let (mut sine, mut cosine) = (vec![0.0; angle.len()], vec![0.0; angle.len()]);
            sines(&angle, wavenumber, &mut sine, &mut cosine);
            for (index, angle) in angle.iter().enumerate() {
                let (s, c) = (angle * wavenumber).sin_cos();
                assert!((sine[index] - s).abs() < 4e-16, "sin {} is {}", angle * wavenumber, sine[index]);
                assert!((cosine[index] - c).abs() < 4e-16, "cos {} is {}", angle * wavenumber, cosine[index]);
            }
        }
    }
}
