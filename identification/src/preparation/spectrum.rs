//! Power spectra: where a signal ends and its noise begins.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use crate::numerics::fourier;
use crate::numerics::vector::{self, dot};
use crate::uncertainty::statistics::{mean, median, running};

/// One-sided power spectral density.
#[derive(Clone, Debug)]
pub(crate) struct Spectrum {
    /// Density at 0, `step_hz`, 2·`step_hz`, …, unit² per Hz.
    pub(crate) density: Vec<f64>,
    /// Distance of two frequencies, Hz.
    pub(crate) step_hz: f64,
}

impl Spectrum {
    /// Welch's estimate: Hann windows of up to 4096 samples, half overlapping, each without its straight line.
    pub(crate) fn welch(signal: &[f64], rate_hz: f64) -> Self {
        Self::with_windows(4096, signal, rate_hz)
    }

    /// The same with windows of up to `longest` samples, a power of two.
    pub(crate) fn with_windows(longest: usize, signal: &[f64], rate_hz: f64) -> Self {
        let mut length = longest;
        while length > 64 && 4 * length > signal.len() {
            length /= 2;
        }
        length = length.min(signal.len() & !1).max(2);
        let places: Vec<f64> = (0..length).map(|i| i as f64).collect();
        let (mut window, mut sine) = (vec![0.0; length], vec![0.0; length]);
        vector::sines(&places, TAU / length as f64, &mut sine, &mut window);
        window.iter_mut().for_each(|cosine| *cosine = 0.5 - 0.5 * *cosine);
        let power: f64 = window.iter().map(|w| w * w).sum();
        let transform = fourier::forward(length);
        let mut buffer = transform.make_input_vec();
        let mut bins = transform.make_output_vec();
        let mut density = vec![0.0; bins.len()];
        let mut count = 0.0;
        for part in signal.windows(length).step_by((length / 2).max(1)) {
            let (mean, slope) = line(part, &places);
            let middle = 0.5 * (length as f64 - 1.0);
            for (i, slot) in buffer.iter_mut().enumerate() {
                *slot = (part[i] - mean - slope * (i as f64 - middle)) * window[i];
            }
            if transform.process(&mut buffer, &mut bins).is_ok() {
                density.iter_mut().zip(&bins).for_each(|(sum, bin)| *sum += bin.norm_sqr());
                count += 1.0;
            }
        }
        let scale = 2.0 / (rate_hz * power * f64::max(count, 1.0));
        density.iter_mut().for_each(|value| *value *= scale);
        Self { density, step_hz: rate_hz / length as f64 }
    }

    /// Median density between two frequencies.
    pub(crate) fn median(&self, from_hz: f64, to_hz: f64) -> f64 {
        self.median_of(from_hz..=to_hz, |_, density| density)
    }

    /// Median of what `of` makes of the frequencies in a range and of their densities.
    pub(crate) fn median_of(&self, range_hz: RangeInclusive<f64>, of: impl Fn(f64, f64) -> f64) -> f64 {
        let within = self.frequencies().zip(&self.density).filter(|(frequency, _)| range_hz.contains(frequency));
        median(&mut within.map(|(frequency, density)| of(frequency, *density)).collect::<Vec<_>>())
    }

    /// The frequencies of the densities, Hz.
    pub(crate) fn frequencies(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.density.len()).map(|index| index as f64 * self.step_hz)
    }

    /// Frequency below which `share` of the power above `floor` lies, Hz.
    pub(crate) fn power_below(&self, share: f64, floor: f64) -> f64 {
        let excess: Vec<f64> =
            self.smooth().iter().map(|density| if *density > floor { *density } else { 0.0 }).collect();
        let total: f64 = excess.iter().sum();
        let mut sum = 0.0;
        let reaches = |(_, power): &(f64, &f64)| {
            sum += *power;
            sum >= share * total
        };
        self.frequencies().zip(&excess).find(reaches).map_or(0.0, |(frequency, _)| frequency)
    }

    /// Running mean over five bins.
    pub(crate) fn smooth(&self) -> Vec<f64> {
        running(&self.density, 2, |near| mean(near))
    }
}

/// Density of white noise that shows in the second difference of a signal, unit² per Hz.
///
/// The second difference takes away the slow motion, which would otherwise leak over the noise.
pub(crate) fn white_density(signal: &[f64], rate_hz: f64) -> f64 {
    let second: Vec<f64> = signal.windows(3).map(|w| w[0] - 2.0 * w[1] + w[2]).collect();
    Spectrum::welch(&second, rate_hz).median_of(0.3 * rate_hz..=0.45 * rate_hz, |frequency_hz, density| {
        density / (2.0 * (PI * frequency_hz / rate_hz).sin()).powi(4)
    })
}

/// Mean and slope per sample of the straight line through a signal at `places` 0, 1, ….
pub(crate) fn line(signal: &[f64], places: &[f64]) -> (f64, f64) {
    let count = signal.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let mean = vector::sum(signal) / count;
    let moment = dot(places, signal) - middle * count * mean;
    (mean, moment / (count * (count * count - 1.0) / 12.0))
}
