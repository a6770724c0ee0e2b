//! What the encoder sees of the motion: the sweep, and how far up in frequency the acceleration is signal.

use super::spectrum::Spectrum;
use crate::uncertainty::statistics::median;

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

/// The motion and the noise in an angle's spectrum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AngleSpectrum {
    /// Frequency below which nearly all of the velocity's power lies, Hz.
    pub(crate) sweep_hz: f64,
    /// Edge of the widest band in which the acceleration is signal, Hz.
    pub(crate) clear_hz: f64,
    /// Density of the encoder's noise up to that edge, rad²/Hz.
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
        // White noise up to a frequency adds the integral of its fourth power to the acceleration.
        let is_clear = |(index, noise): &&(usize, f64)| {
            noise * frequencies[*index].powi(5) / 5.0 <= NOISE_IN_BAND * acceleration[*index]
        };
        let (clear, noise_density) = *noise.iter().find(is_clear).unwrap_or(&noise[noise.len() - 1]);
        let sweep = velocity.iter().position(|sum| *sum >= SWEEP_POWER * velocity[clear]).unwrap_or(clear);
        Self { sweep_hz: frequencies[sweep.max(1)], clear_hz: frequencies[clear], noise_density }
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
