//! Sensor noise and quantisation.

use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

/// White Gaussian noise, the same for the same seed.
#[derive(Debug)]
pub(super) struct Noise {
    generator: Xoshiro256PlusPlus,
    scale: f64,
}

impl Noise {
    pub(super) fn new(seed: u64, scale: f64) -> Self {
        Self { generator: Xoshiro256PlusPlus::seed_from_u64(seed), scale }
    }

    /// A sample with the standard deviation `rms`.
    pub(super) fn sample(&mut self, rms: f64) -> f64 {
        let sample: f64 = StandardNormal.sample(&mut self.generator);
        self.scale * rms * sample
    }
}

/// `value` on a grid of `step`; a step of zero leaves it as it is.
pub(super) fn quantised(value: f64, step: f64) -> f64 {
    if step > 0.0 { (value / step).round() * step } else { value }
}
