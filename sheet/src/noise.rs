//! What a curve's own noise does to its figures.

use identification::statistics::{mean, standard_deviation};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{RngCore, SeedableRng};

/// Times that the noise is drawn anew: the standard deviation of a figure is then known to 5 %.
pub(crate) const DRAWS: usize = 200;
/// The draws are the same ones each time, so that a curve has one sheet.
const SEED: u64 = 21;

/// Random signs for the residuals, drawn anew each time. The residuals keep their magnitudes, so the noise may vary along the curve
/// (the wild bootstrap; C. F. J. Wu, Ann. Statist. 14, 1986, 1261–1295, with the signs of Liu 1988).
pub(crate) struct Signs(Xoshiro256PlusPlus);

impl Signs {
    pub(crate) fn new() -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(SEED))
    }

    /// `smooth` with each residual added or taken off.
    pub(crate) fn redraw(&mut self, smooth: &[f64], residual: &[f64]) -> Vec<f64> {
        let mut bits = 0;
        let mut sign = |index: usize| {
            if index.is_multiple_of(64) {
                bits = self.0.next_u64();
            }
            if bits >> (index % 64) & 1 == 1 { 1.0 } else { -1.0 }
        };
        smooth.iter().zip(residual).enumerate().map(|(index, (smooth, left))| smooth + sign(index) * left).collect()
    }
}

/// Mean and standard deviation; `None` of fewer than two values.
pub(crate) fn mean_and_deviation(values: &[f64]) -> Option<(f64, f64)> {
    (values.len() > 1).then(|| (mean(values), standard_deviation(values)))
}
