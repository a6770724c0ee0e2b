//! Low-pass designs: Butterworth and Chebyshev of both kinds.

use std::f64::consts::PI;

use nalgebra::Complex;

use super::Sections;

/// Butterworth low-pass: −3 dB at `edge_hz`; `None` for an order outside 1 to 20 or an edge outside (0, `rate_hz`/2).
#[must_use]
pub fn butterworth_low_pass(order: usize, edge_hz: f64, rate_hz: f64) -> Option<Sections> {
    digital_low_pass(&[], &prototype_poles(order), 1.0, edge_hz, rate_hz)
}

/// Chebyshev low-pass of the first kind: within `ripple_db` of unit gain up to `edge_hz`, steep beyond; `None` for an order outside 1 to 20,
/// an edge outside (0, `rate_hz`/2) or a ripple not above zero.
#[must_use]
pub fn chebyshev1_low_pass(order: usize, ripple_db: f64, edge_hz: f64, rate_hz: f64) -> Option<Sections> {
    if ripple_db.is_nan() || ripple_db <= 0.0 {
        return None;
    }
    let ripple = (10_f64.powf(0.1 * ripple_db) - 1.0).sqrt();
    let stretch = (1.0 / ripple).asinh() / order as f64;
    let poles: Vec<_> = prototype_poles(order)
        .into_iter()
        .map(|pole| Complex::new(stretch.sinh() * pole.re, stretch.cosh() * pole.im))
        .collect();
    let gain = poles.iter().map(|pole| -pole).product::<Complex<f64>>().re;
    // Of even order, the gain at frequency zero is at the lower end of the ripple.
    let gain = if order.is_multiple_of(2) { gain / ripple.hypot(1.0) } else { gain };
    digital_low_pass(&[], &poles, gain, edge_hz, rate_hz)
}

/// Chebyshev low-pass of the second kind: flat pass band, at least `attenuation_db` from `edge_hz` upwards; `None` for an order outside
/// 1 to 20, an edge outside (0, `rate_hz`/2) or an attenuation not above zero.
#[must_use]
pub fn chebyshev2_low_pass(order: usize, attenuation_db: f64, edge_hz: f64, rate_hz: f64) -> Option<Sections> {
    if attenuation_db.is_nan() || attenuation_db <= 0.0 {
        return None;
    }
    let stretch = (10_f64.powf(0.1 * attenuation_db) - 1.0).sqrt().asinh() / order as f64;
    let zeros: Vec<_> =
        half_angles(order).filter(|angle| *angle != 0.0).map(|angle| Complex::new(0.0, 1.0 / angle.sin())).collect();
    let poles: Vec<_> = prototype_poles(order)
        .into_iter()
        .map(|pole| Complex::new(stretch.sinh() * pole.re, stretch.cosh() * pole.im).inv())
        .collect();
    let product = |roots: &[Complex<f64>]| roots.iter().map(|root| -root).product::<Complex<f64>>();
    let gain = (product(&poles) / product(&zeros)).re;
    digital_low_pass(&zeros, &poles, gain, edge_hz, rate_hz)
}

/// The angles π·m/(2·order) for m = −order+1, −order+3, …, order−1.
fn half_angles(order: usize) -> impl Iterator<Item = f64> {
    (0..order).map(move |index| (2.0 * index as f64 + 1.0 - order as f64) * PI / (2.0 * order as f64))
}

fn prototype_poles(order: usize) -> Vec<Complex<f64>> {
    half_angles(order).map(|angle| -Complex::from_polar(1.0, angle)).collect()
}

/// Stretches an analogue prototype to the edge, warped, and maps it to the z plane; `None` for an order beyond what double precision carries,
/// or an edge beyond what the sample rate does.
fn digital_low_pass(
    zeros: &[Complex<f64>],
    poles: &[Complex<f64>],
    gain: f64,
    edge_hz: f64,
    rate_hz: f64,
) -> Option<Sections> {
    if !((1..=20).contains(&poles.len()) && edge_hz > 0.0 && edge_hz < 0.5 * rate_hz) {
        return None;
    }
    // The bilinear transform at sample rate 2: s = 4·(z − 1)/(z + 1).
    let scale = 4.0;
    let warped = scale * (PI * edge_hz / rate_hz).tan();
    let excess = poles.len() - zeros.len();
    let stretched = |roots: &[Complex<f64>]| roots.iter().map(|root| root * warped).collect::<Vec<_>>();
    let (zeros, poles) = (stretched(zeros), stretched(poles));
    let powers = i32::try_from(excess).unwrap_or(i32::MAX);
    let distance = |roots: &[Complex<f64>]| roots.iter().map(|root| scale - root).product::<Complex<f64>>();
    let gain = gain * warped.powi(powers) * (distance(&zeros) / distance(&poles)).re;
    let mapped = |roots: &[Complex<f64>]| roots.iter().map(|root| (root + scale) / (-root + scale)).collect::<Vec<_>>();
    let mut zeros = mapped(&zeros);
    zeros.resize(poles.len(), Complex::new(-1.0, 0.0));
    Some(Sections::from_zeros_poles(&zeros, &mapped(&poles), gain))
}
