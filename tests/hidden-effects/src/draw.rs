//! Chance, decided wholly by a seed.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// A source of random numbers with the few draws that the plant needs.
pub struct Draw(Xoshiro256PlusPlus);

impl Draw {
    /// The stream that belongs to a seed and to words that tell one use of it from another.
    pub fn new(seed: u64, words: &str) -> Self {
        // FNV-1a: any mixing that does not change from one Rust release to the next.
        let mix = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        let hash = seed.to_le_bytes().into_iter().chain(words.bytes()).fold(0xcbf2_9ce4_8422_2325, mix);
        Self(Xoshiro256PlusPlus::seed_from_u64(hash))
    }

    /// Evenly between two bounds.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        Uniform::new_inclusive(low, high).map_or(low, |even| even.sample(&mut self.0))
    }

    /// Evenly in the logarithm between two positive bounds.
    pub fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// True with the given probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// An index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.uniform(0.0, count as f64) as usize).min(count.saturating_sub(1))
    }

    /// An angle anywhere on the circle, rad.
    pub fn phase(&mut self) -> f64 {
        self.uniform(-std::f64::consts::PI, std::f64::consts::PI)
    }

    /// A standard normal number.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Eight hexadecimal digits, which say nothing.
    pub fn name(&mut self) -> String {
        format!("{:08x}", self.0.next_u64() >> 32)
    }
}
