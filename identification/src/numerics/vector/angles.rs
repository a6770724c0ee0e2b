//! Loops over angles: sines, and sharing values out among bins of angle.

use std::f64::consts::FRAC_2_PI;

use super::BLOCK;

/// Largest argument that the reduction below takes without losing digits; larger ones go the slow way.
const LARGEST_ARGUMENT: f64 = 1e6;

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
    widest!({
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
    });
}

/// The shares that each value of a block adds to four bins.
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
    widest!({
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
    });
}

/// Sine and cosine of `wavenumber` times every angle, to a unit or two in the last place.
///
/// Cody and Waite's reduction to ±π/4 and the polynomials of fdlibm (`k_sin.c`, `k_cos.c`, Sun Microsystems 1993).
pub(crate) fn sines(angle: &[f64], wavenumber: f64, sine: &mut [f64], cosine: &mut [f64]) {
    widest!({
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
