//! Second-order sections: a filter of any order as a chain of biquads.

use nalgebra::Complex;

use super::extended;

/// Roots closer than this to the real axis count as real.
const REAL: f64 = 1e-12;

/// A digital filter as a chain of second-order sections (b0, b1, b2, 1, a1, a2).
#[derive(Clone, Debug, PartialEq)]
pub struct Sections {
    sections: Vec<[f64; 6]>,
}

impl Sections {
    /// The sections as rows (b0, b1, b2, a0 = 1, a1, a2), the gain in the first.
    #[must_use]
    pub fn rows(&self) -> &[[f64; 6]] {
        &self.sections
    }

    /// One section (b0, b1, b2, 1, a1, a2).
    pub(crate) fn of_one(section: [f64; 6]) -> Self {
        Self { sections: vec![section] }
    }

    /// Pairs each pair of poles with its nearest zeros; the pair closest to the unit circle comes last.
    pub(super) fn from_zeros_poles(zeros: &[Complex<f64>], poles: &[Complex<f64>], gain: f64) -> Self {
        let (mut zeros, mut poles) = (zeros.to_vec(), poles.to_vec());
        if poles.len() % 2 == 1 {
            zeros.push(Complex::new(0.0, 0.0));
            poles.push(Complex::new(0.0, 0.0));
        }
        let mut sections = Vec::new();
        while !poles.is_empty() {
            let first = take_nearest(&mut poles, |pole| (1.0 - pole.norm()).abs());
            let second = take_partner(&mut poles, first, |pole| (1.0 - pole.norm()).abs());
            let zero = take_nearest(&mut zeros, |zero| (zero - first).norm());
            let other = take_partner(&mut zeros, zero, |candidate| (candidate - first).norm());
            sections.push([1.0, -(zero + other).re, (zero * other).re, 1.0, -(first + second).re, (first * second).re]);
        }
        sections.reverse();
        if let Some(section) = sections.first_mut() {
            section[..3].iter_mut().for_each(|coefficient| *coefficient *= gain);
        }
        Self { sections }
    }

    /// Filters causally, with the memory of a filter that has seen the constant `settled_at` for ever.
    #[must_use]
    pub fn filter(&self, input: &[f64], settled_at: f64) -> Vec<f64> {
        let mut level = settled_at;
        let settled = |[b0, b1, b2, _, a1, a2]: &[f64; 6]| {
            let out = level * (b0 + b1 + b2) / (1.0 + a1 + a2);
            let second = b2 * level - a2 * out;
            let first = b1 * level - a1 * out + second;
            level = out;
            [first, second]
        };
        let mut memory: Vec<[f64; 2]> = self.sections.iter().map(settled).collect();
        let step = |input: &f64| {
            self.sections.iter().zip(&mut memory).fold(*input, |value, ([b0, b1, b2, _, a1, a2], [first, second])| {
                let out = b0 * value + *first;
                *first = b1 * value - a1 * out + *second;
                *second = b2 * value - a2 * out;
                out
            })
        };
        input.iter().map(step).collect()
    }

    /// Filters forwards and backwards: no phase shift, the squared gain.
    ///
    /// The ends are extended by point reflection, as `scipy.signal.sosfiltfilt` does by default.
    #[must_use]
    pub fn filter_zero_phase(&self, input: &[f64]) -> Vec<f64> {
        if input.is_empty() {
            return Vec::new();
        }
        let pad = self.pad_length().min(input.len() - 1);
        let mut extended = extended(input, pad);
        for _ in 0..2 {
            extended = self.filter(&extended, extended[0]);
            extended.reverse();
        }
        extended[pad..pad + input.len()].to_vec()
    }

    /// Length of the extension at each end that `scipy.signal.sosfiltfilt` takes by default.
    fn pad_length(&self) -> usize {
        let vanishing = |index: usize| self.sections.iter().filter(|section| section[index] == 0.0).count();
        3 * (2 * self.sections.len() + 1 - vanishing(2).min(vanishing(5)))
    }
}

fn take_nearest(roots: &mut Vec<Complex<f64>>, distance: impl Fn(&Complex<f64>) -> f64) -> Complex<f64> {
    let index = (0..roots.len()).min_by(|a, b| distance(&roots[*a]).total_cmp(&distance(&roots[*b]))).unwrap_or(0);
    roots.remove(index)
}

/// Takes the root that makes a real section with `root`: its conjugate, or for a real one the best other real one.
fn take_partner(
    roots: &mut Vec<Complex<f64>>,
    root: Complex<f64>,
    distance: impl Fn(&Complex<f64>) -> f64,
) -> Complex<f64> {
    if root.im.abs() > REAL {
        take_nearest(roots, |candidate| (candidate - root.conj()).norm())
    } else {
        take_nearest(roots, |candidate| distance(candidate) + if candidate.im.abs() > REAL { 1e6 } else { 0.0 })
    }
}
