//! Finite impulse response filters with linear phase.

use std::f64::consts::PI;

use super::extended;
use crate::numerics::vector;

/// A low-pass with an odd, symmetric impulse response of unit gain at zero frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct Fir {
    taps: Vec<f64>,
}

impl Fir {
    /// Windowed-sinc low-pass (Hamming): −6 dB at `edge_hz`, `half_length` taps on each side of the middle.
    ///
    /// The same taps as `scipy.signal.firwin(2·half_length + 1, edge_hz, fs=rate_hz)`.
    #[must_use]
    pub fn low_pass(half_length: usize, edge_hz: f64, rate_hz: f64) -> Self {
        Self::windowed_sinc(half_length, edge_hz, rate_hz, |place| 0.54 + 0.46 * (PI * place).cos())
    }

    /// Windowed-sinc low-pass (Kaiser): −6 dB at `edge_hz`; the larger `beta`, the flatter and the less steep.
    ///
    /// The same taps as `scipy.signal.firwin(2·half_length + 1, edge_hz, window=("kaiser", beta), fs=rate_hz)`.
    #[must_use]
    pub fn kaiser_low_pass(half_length: usize, edge_hz: f64, rate_hz: f64, beta: f64) -> Self {
        let whole = bessel_i0(beta);
        let window = |place: f64| bessel_i0(beta * (1.0 - place * place).max(0.0).sqrt()) / whole;
        Self::windowed_sinc(half_length, edge_hz, rate_hz, window)
    }

    /// The filter that leaves everything as it is.
    #[must_use]
    pub fn identity() -> Self {
        Self { taps: vec![1.0] }
    }

    /// A filter of symmetric taps, scaled to unit gain at frequency zero; their number must be odd.
    #[must_use]
    pub(crate) fn of_taps(taps: &[f64]) -> Self {
        let sum: f64 = taps.iter().sum();
        Self { taps: taps.iter().map(|tap| tap / sum).collect() }
    }

    /// `window` is a function of the place between −1 and 1.
    fn windowed_sinc(half_length: usize, edge_hz: f64, rate_hz: f64, window: impl Fn(f64) -> f64) -> Self {
        let width = 2.0 * edge_hz / rate_hz;
        let taps: Vec<f64> = (0..=2 * half_length)
            .map(|index| {
                let offset = index as f64 - half_length as f64;
                let angle = PI * width * offset;
                let sinc = if offset == 0.0 { width } else { width * angle.sin() / angle };
                sinc * window(offset / half_length.max(1) as f64)
            })
            .collect();
        Self::of_taps(&taps)
    }

    /// The impulse response.
    #[must_use]
    pub fn taps(&self) -> &[f64] {
        &self.taps
    }

    /// Taps on each side of the middle.
    #[must_use]
    pub fn half_length(&self) -> usize {
        self.taps.len() / 2
    }

    /// Filters without delay; the ends are extended by point reflection.
    #[must_use]
    pub fn filter(&self, input: &[f64]) -> Vec<f64> {
        if input.is_empty() {
            return Vec::new();
        }
        let pad = self.half_length().min(input.len() - 1);
        let mut output = vec![0.0; input.len()];
        self.decimate_part(&extended(input, pad), pad, 1, &mut output);
        output
    }

    /// Filters without delay and keeps every `step`-th sample, the first included; beyond the ends the input counts as zero.
    ///
    /// Only the samples kept are computed: length/step · taps multiplications.
    #[must_use]
    pub fn decimate(&self, input: &[f64], step: usize) -> Vec<f64> {
        let mut output = vec![0.0; input.len().div_ceil(step)];
        self.decimate_part(input, 0, step, &mut output);
        output
    }

    /// The output at `first`, `first + step`, … of the input.
    pub(crate) fn decimate_part(&self, input: &[f64], first: usize, step: usize, output: &mut [f64]) {
        let half = self.half_length();
        // Outputs whose taps all lie inside the input.
        let inside = half.saturating_sub(first).div_ceil(step).min(output.len());
        let whole = (input.len() + step).saturating_sub(first + half + 1) / step;
        let outside = whole.clamp(inside, output.len());
        for index in (0..inside).chain(outside..output.len()) {
            output[index] = self.at(input, first + index * step);
        }
        if outside > inside {
            let start = first + inside * step - half;
            vector::decimate(&input[start..], &self.taps, step, &mut output[inside..outside]);
        }
    }

    /// The output at one place; beyond the ends the input counts as zero.
    fn at(&self, input: &[f64], centre: usize) -> f64 {
        let half = self.half_length();
        let first = centre.saturating_sub(half);
        let last = (centre + half + 1).min(input.len());
        input[first..last].iter().zip(&self.taps[first + half - centre..]).map(|(value, tap)| value * tap).sum()
    }

    /// The adjoint of [`Fir::decimate`]: spreads every kept sample back over `length` samples.
    #[must_use]
    pub fn spread(&self, kept: &[f64], step: usize, length: usize) -> Vec<f64> {
        let half = self.half_length();
        let mut output = vec![0.0; (length + 2 * half).max((kept.len().saturating_sub(1)) * step + self.taps.len())];
        vector::spread(kept, &self.taps, step, &mut output);
        output.drain(..half);
        output.truncate(length);
        output
    }

    /// Gain at a frequency; real, since the phase is zero about the middle tap.
    #[must_use]
    pub fn gain(&self, frequency_hz: f64, rate_hz: f64) -> f64 {
        let step = (2.0 * PI * frequency_hz / rate_hz).cos();
        // cos((m + 1)x) = 2·cos x·cos mx − cos((m − 1)x), outwards from the middle tap.
        let (mut before, mut cosine) = (step, 1.0);
        let mut taps = self.taps[self.half_length()..].iter();
        let mut gain = taps.next().copied().unwrap_or(0.0);
        for tap in taps {
            (before, cosine) = (cosine, 2.0 * step * cosine - before);
            gain += 2.0 * tap * cosine;
        }
        gain
    }
}

/// Modified Bessel function of the first kind and order zero, by its power series.
fn bessel_i0(argument: f64) -> f64 {
    let quarter = 0.25 * argument * argument;
    let (mut term, mut sum, mut order) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= quarter / (order * order);
        sum += term;
        order += 1.0;
    }
    sum
}
