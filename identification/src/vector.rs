//! The few loops that take the time, compiled for the widest vectors that the processor has.
//!
//! Nothing is assumed of the processor: `pulp` looks once and picks among copies of each loop.

use std::f64::consts::FRAC_2_PI;
use std::ops::Deref;

use nalgebra::DMatrix;
use pulp::Arch;

/// Rows that are looked at together: a dozen columns of them stay in the first-level cache.
const BLOCK: usize = 512;
/// Independent partial sums.
const LANES: usize = 16;
/// Largest argument that the reduction below takes without losing digits; larger ones go the slow way.
const LARGEST_ARGUMENT: f64 = 1e6;

/// Inner product of two columns of one length.
pub(crate) fn dot(left: &[f64], right: &[f64]) -> f64 {
    Arch::new().dispatch(|| dot_inline(left, right))
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
    Arch::new().dispatch(|| {
        for start in (0..rows).step_by(BLOCK) {
            let block = start..(start + BLOCK).min(rows);
            for row in from..columns.len() {
                for column in 0..=row {
                    products[(row, column)] +=
                        dot_inline(&columns[row][block.clone()], &columns[column][block.clone()]);
                }
            }
        }
    });
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
    Arch::new().dispatch(|| {
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
    });
    products
}

/// Row by row product of two columns.
pub(crate) fn multiply(left: &[f64], right: &[f64]) -> Vec<f64> {
    left.iter().zip(right).map(|(left, right)| left * right).collect()
}

/// `xᵀ·matrix·x` for the symmetric `matrix` and every row x of the columns.
pub(crate) fn quadratic_form<C: Deref<Target = [f64]>>(columns: &[C], matrix: &DMatrix<f64>, output: &mut [f64]) {
    let rows = output.len();
    output.fill(0.0);
    Arch::new().dispatch(|| {
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
                for ((slot, sum), value) in output[block.clone()].iter_mut().zip(&*inner).zip(&column[block.clone()]) {
                    *slot += sum * value;
                }
            }
        }
    });
}

/// Every `step`-th sample of a filtered signal: `output[i] = Σ taps[j] · input[i · step + j]`.
///
/// With the input sorted by its place modulo `step`, neighbouring outputs take neighbouring inputs: whole vectors of
/// outputs are summed at once.
pub(crate) fn decimate(input: &[f64], taps: &[f64], step: usize, output: &mut [f64]) {
    let length = output.len() + taps.len().div_ceil(step);
    let mut phases = vec![0.0; length * step];
    let places: Vec<(usize, f64)> =
        taps.iter().enumerate().map(|(index, tap)| ((index % step) * length + index / step, *tap)).collect();
    Arch::new().dispatch(|| {
        for (place, values) in input.chunks(step).take(length).enumerate() {
            for (phase, value) in values.iter().enumerate() {
                phases[phase * length + place] = *value;
            }
        }
        let (blocks, rest) = output.as_chunks_mut::<LANES>();
        for (block, start) in blocks.iter_mut().zip((0..).step_by(LANES)) {
            let mut sums = [0.0; LANES];
            for (place, tap) in &places {
                let place = place + start;
                for (sum, value) in sums.iter_mut().zip(&phases[place..place + LANES]) {
                    *sum += tap * value;
                }
            }
            *block = sums;
        }
        let done = blocks.len() * LANES;
        for (slot, window) in rest.iter_mut().zip(input.windows(taps.len()).step_by(step).skip(done)) {
            *slot = dot_inline(window, taps);
        }
    });
}

/// The adjoint of [`decimate`]: adds `kept[i] · taps[j]` to `output[i · step + j]`.
pub(crate) fn spread(kept: &[f64], taps: &[f64], step: usize, output: &mut [f64]) {
    Arch::new().dispatch(|| {
        for (index, value) in kept.iter().enumerate() {
            for (slot, tap) in output[index * step..index * step + taps.len()].iter_mut().zip(taps) {
                *slot += value * tap;
            }
        }
    });
}

/// Shares every value out among four bins by a cubic spline; its place lies between the second and the third of them.
pub(crate) fn share_out(values: &[f64], angles: &[f64], offset_rad: f64, bin_rad: f64, bins: &mut [f64]) {
    let per_bin = 1.0 / bin_rad;
    let Some(last) = bins.len().checked_sub(4) else { return };
    Arch::new().dispatch(|| {
        for (value, angle) in values.iter().zip(angles) {
            let place = ((angle - offset_rad) * per_bin).max(0.0);
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index of a bin")]
            let index = place as u32;
            let share = place - f64::from(index);
            let rest = 1.0 - share;
            let sixth = value / 6.0;
            let shares = [
                sixth * rest * rest * rest,
                sixth * (4.0 - 3.0 * share * share * (1.0 + rest)),
                sixth * (4.0 - 3.0 * rest * rest * (1.0 + share)),
                sixth * share * share * share,
            ];
            let first = (index as usize).min(last);
            for (bin, share) in bins[first..first + 4].iter_mut().zip(shares) {
                *bin += share;
            }
        }
    });
}

/// Sine and cosine of `wavenumber` times every angle, to a unit or two in the last place.
///
/// Cody and Waite's reduction to ±π/4 and the polynomials of fdlibm (`k_sin.c`, `k_cos.c`, Sun Microsystems 1993).
pub(crate) fn sines(angle: &[f64], wavenumber: f64, sine: &mut [f64], cosine: &mut [f64]) {
    Arch::new().dispatch(|| {
        let mut too_large = 0_u64;
        for ((angle, sine), cosine) in angle.iter().zip(sine.iter_mut()).zip(cosine.iter_mut()) {
            let argument = angle * wavenumber;
            too_large |= u64::from(argument.abs() > LARGEST_ARGUMENT);
            (*sine, *cosine) = sine_cosine(argument);
        }
        if too_large != 0 {
            for ((angle, sine), cosine) in angle.iter().zip(sine).zip(cosine) {
                (*sine, *cosine) = (angle * wavenumber).sin_cos();
            }
        }
    });
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
