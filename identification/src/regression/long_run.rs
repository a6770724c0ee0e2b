//! The long-run covariance of correlated scores.
//!
//! Newey and West's estimate with Parzen's kernel and the bandwidth of Andrews (Econometrica 59, 1991, 817–858) from
//! first-order autocorrelations. Parzen's kernel is a triangle convolved with itself, and a triangle is a box convolved
//! with itself: the result has no negative eigenvalue.

use nalgebra::DMatrix;

use crate::numerics::vector::{self, dot, square};

/// Places at which half of the kernel is told apart.
const PLACES_PER_HALF: usize = 16;
/// Least bandwidth as a share of the rows.
const SHARE: f64 = 0.02;
/// ∫k² of Parzen's kernel from −1 to 1.
pub(crate) const PARZEN_SQUARES: f64 = 151.0 / 280.0;

/// The long-run covariance of scores, and the bandwidth of its kernel in rows.
pub(crate) fn covariance(scores: &[Vec<f64>]) -> (DMatrix<f64>, f64) {
    let rows = scores.first().map_or(0, Vec::len);
    let half = (0.5 * parzen_bandwidth(scores, rows)).round().max(1.0) as usize;
    // Neighbours far closer than the bandwidth count as one.
    let group = (half / PLACES_PER_HALF).max(1);
    let width = half.div_ceil(group);
    let smooth = |score: &Vec<f64>| {
        let places: Vec<f64> = score.chunks(group).map(|part| part.iter().sum()).collect();
        vector::triangle(&places, width)
    };
    let covariance = vector::gram(&scores.iter().map(smooth).collect::<Vec<_>>()) * kernel_scale(width);
    (covariance, 2.0 * (width * group) as f64)
}

/// One over the triangle's sum of squares, which scales the kernel to one at lag zero.
pub(crate) fn kernel_scale(width: usize) -> f64 {
    let width = width as f64;
    3.0 / (width * (2.0 * width * width + 1.0))
}

fn parzen_bandwidth(scores: &[Vec<f64>], rows: usize) -> f64 {
    let (mut above, mut below) = (0.0, 0.0);
    for score in scores {
        let variance = square(score);
        if variance <= 0.0 {
            continue;
        }
        let correlation = (dot(&score[1..], score) / variance).clamp(-0.97, 0.97);
        // Scores count alike whatever their unit, so the variances drop out.
        above += 4.0 * correlation.powi(2) / (1.0 - correlation).powi(8);
        below += 1.0 / (1.0 - correlation).powi(4);
    }
    let plug_in = if below > 0.0 { 2.6614 * (above / below * rows as f64).powf(0.2) } else { 0.0 };
    // First-order autocorrelations do not see all: a share of the rows.
    plug_in.max((SHARE * rows as f64).clamp(8.0, 64.0)).min((rows as f64 / 8.0).max(1.0))
}
