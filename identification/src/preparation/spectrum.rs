//! Power spectra: where a signal ends and its noise begins, and how far up in frequency an encoder's acceleration is signal.

use std::f64::consts::{PI, TAU};
use std::ops::RangeInclusive;

use crate::numerics::statistics::{mean, median, running, without_line};
use crate::numerics::{fourier, vector};

/// Longest window of the spectrum, samples: it must tell a motion of 1 Hz from none at 20 kHz.
const LONGEST_WINDOW: usize = 1 << 15;
/// Share of the velocity's power that lies in the sweep itself; the rest is jumps when the knob slips.
const SWEEP_POWER: f64 = 0.95;
/// Noise in the acceleration's power up to the band's edge. The noise that is known is taken off again
/// ([`SensorNoise`](super::sensor_noise::SensorNoise)); this bounds what is left of it where it is not white.
const NOISE_IN_BAND: f64 = 1e-4;
/// Bands per octave in which the noise is read.
const PER_OCTAVE: i32 = 4;
/// Noise does not fall faster than this from one octave to the next: a motion does, beyond its sweep.
const STEEPEST_NOISE: f64 = 8.0;

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
            for ((slot, value), weight) in buffer.iter_mut().zip(without_line(part, &places)).zip(&window) {
                *slot = value * weight;
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

    /// Frequency, Hz, below which lies `share` of the power of those lines that exceed `floor`.
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

/// The motion and the noise in an angle's spectrum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AngleSpectrum {
    /// Frequency below which nearly all of the velocity's power lies, Hz.
    pub(crate) sweep_hz: f64,
    /// Edge of the widest band in which the acceleration is signal, Hz; at least the sweep's.
    pub(crate) clear_hz: f64,
    /// Density of the encoder's noise up to where the acceleration is last signal, rad²/Hz.
    pub(crate) noise_density: f64,
}

impl AngleSpectrum {
    pub(crate) fn of(angle_rad: &[f64], rate_hz: f64) -> Self {
        let spectrum = Spectrum::with_windows(LONGEST_WINDOW, angle_rad, rate_hz);
        let density = spectrum.smooth();
        let frequencies: Vec<f64> = spectrum.frequencies().collect();
        // Power up to each frequency of the velocity (order 2) or the acceleration (order 4), over (2π)^order.
        let power = |order: i32| -> Vec<f64> {
            let terms = frequencies.iter().zip(&density).map(|(frequency, density)| frequency.powi(order) * density);
            let sums = terms.scan(0.0, |sum, term| {
                *sum += term * spectrum.step_hz;
                Some(*sum)
            });
            sums.collect()
        };
        let (velocity, acceleration) = (power(2), power(4));
        let noise = noise_densities(&density);
        // White noise of the angle adds to the acceleration's power the integral of the frequency's fourth power.
        let is_clear = |(index, noise): &&(usize, f64)| {
            noise * frequencies[*index].powi(5) / 5.0 <= NOISE_IN_BAND * acceleration[*index]
        };
        let (clear, noise_density) = *noise.iter().find(is_clear).unwrap_or(&noise[noise.len() - 1]);
        let sweep = velocity.iter().position(|sum| *sum >= SWEEP_POWER * velocity[clear]).unwrap_or(clear);
        let sweep_hz = frequencies[sweep.max(1)];
        Self { sweep_hz, clear_hz: frequencies[clear].max(sweep_hz), noise_density }
    }
}

/// Bins, from half of Nyquist's frequency down, each with the density of the noise above it.
///
/// The steps of a coarse encoder are not white where the knob turns slowly, so the noise is read just above each bin as long
/// as that continues the noise further up; where the density rises steeply towards lower frequencies, the motion begins.
fn noise_densities(density: &[f64]) -> Vec<(usize, f64)> {
    let above = |index: usize| median(&mut density[index..(2 * index).min(density.len())].to_vec());
    let top = (density.len() / 2).max(1);
    let mut noise: Vec<(usize, f64)> = vec![(top, above(top))];
    for step in 1.. {
        let index = (top as f64 * 0.5_f64.powf(f64::from(step) / f64::from(PER_OCTAVE))) as usize;
        if index == 0 {
            break;
        }
        let an_octave_up = noise[noise.len().saturating_sub(PER_OCTAVE as usize)].1;
        let here = above(index);
        let is_noise = here <= STEEPEST_NOISE * an_octave_up;
        noise.push((index, if is_noise { here.max(an_octave_up) } else { an_octave_up }));
    }
    noise
}
