//! Low-pass designs: Butterworth and Chebyshev of both kinds.

use std::f64::consts::PI;

use nalgebra::Complex;

use super::Sections;

/// A filter that cannot be designed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// An order of zero or beyond what double precision carries.
    #[error("the filter's order is {order}, but it must be 1 to 20")]
    Order {
        /// The order asked for.
        order: usize,
    },
    /// An edge frequency that the sample rate cannot carry.
    #[error("the filter's edge of {edge_hz} Hz must lie above 0 and below half the sample rate of {rate_hz} Hz")]
    Edge {
        /// The edge asked for, Hz.
        edge_hz: f64,
        /// The sample rate, Hz.
        rate_hz: f64,
    },
    /// A stop band that does not attenuate, or a pass band without ripple.
    #[error("the filter's attenuation of {attenuation_db} dB must be above 0")]
    Attenuation {
        /// The attenuation asked for, dB.
        attenuation_db: f64,
    },
}

/// Zeros, poles and gain.
struct ZerosPolesGain {
    zeros: Vec<Complex<f64>>,
    poles: Vec<Complex<f64>>,
    gain: f64,
}

/// Butterworth low-pass: −3 dB at `edge_hz`.
///
/// # Errors
/// [`FilterError`] for an order outside 1 to 20 or an edge outside (0, `rate_hz`/2).
pub fn butterworth_low_pass(order: usize, edge_hz: f64, rate_hz: f64) -> Result<Sections, FilterError> {
    check(order, edge_hz, rate_hz)?;
    let poles = prototype_poles(order);
    Ok(digital_low_pass(ZerosPolesGain { zeros: Vec::new(), poles, gain: 1.0 }, edge_hz, rate_hz))
}

/// Chebyshev low-pass of the first kind: within `ripple_db` of unit gain up to `edge_hz`, steep beyond.
///
/// # Errors
/// [`FilterError`] for an order outside 1 to 20, an edge outside (0, `rate_hz`/2) or a ripple not above zero.
pub fn chebyshev1_low_pass(order: usize, ripple_db: f64, edge_hz: f64, rate_hz: f64) -> Result<Sections, FilterError> {
    check(order, edge_hz, rate_hz)?;
    if ripple_db.is_nan() || ripple_db <= 0.0 {
        return Err(FilterError::Attenuation { attenuation_db: ripple_db });
    }
    let ripple = (10_f64.powf(0.1 * ripple_db) - 1.0).sqrt();
    let stretch = (1.0 / ripple).asinh() / as_f64(order);
    let poles: Vec<_> = prototype_poles(order)
        .into_iter()
        .map(|pole| Complex::new(stretch.sinh() * pole.re, stretch.cosh() * pole.im))
        .collect();
    let gain = poles.iter().map(|pole| -pole).product::<Complex<f64>>().re;
    // Of even order, the gain at frequency zero is at the lower end of the ripple.
    let gain = if order.is_multiple_of(2) { gain / ripple.hypot(1.0) } else { gain };
    Ok(digital_low_pass(ZerosPolesGain { zeros: Vec::new(), poles, gain }, edge_hz, rate_hz))
}

/// Chebyshev low-pass of the second kind: flat pass band, at least `attenuation_db` from `edge_hz` upwards.
///
/// # Errors
/// [`FilterError`] for an order outside 1 to 20, an edge outside (0, `rate_hz`/2) or an attenuation not above zero.
pub fn chebyshev2_low_pass(
    order: usize,
    attenuation_db: f64,
    edge_hz: f64,
    rate_hz: f64,
) -> Result<Sections, FilterError> {
    check(order, edge_hz, rate_hz)?;
    if attenuation_db.is_nan() || attenuation_db <= 0.0 {
        return Err(FilterError::Attenuation { attenuation_db });
    }
    let stretch = (10_f64.powf(0.1 * attenuation_db) - 1.0).sqrt().asinh() / as_f64(order);
    let zeros: Vec<_> =
        half_angles(order).filter(|angle| *angle != 0.0).map(|angle| Complex::new(0.0, 1.0 / angle.sin())).collect();
    let poles: Vec<_> = prototype_poles(order)
        .into_iter()
        .map(|pole| Complex::new(stretch.sinh() * pole.re, stretch.cosh() * pole.im).inv())
        .collect();
    let product = |roots: &[Complex<f64>]| roots.iter().map(|root| -root).product::<Complex<f64>>();
    let gain = (product(&poles) / product(&zeros)).re;
    Ok(digital_low_pass(ZerosPolesGain { zeros, poles, gain }, edge_hz, rate_hz))
}

fn check(order: usize, edge_hz: f64, rate_hz: f64) -> Result<(), FilterError> {
    if !(1..=20).contains(&order) {
        return Err(FilterError::Order { order });
    }
    if !(edge_hz > 0.0 && edge_hz < 0.5 * rate_hz) {
        return Err(FilterError::Edge { edge_hz, rate_hz });
    }
    Ok(())
}

/// The angles π·m/(2·order) for m = −order+1, −order+3, …, order−1.
fn half_angles(order: usize) -> impl Iterator<Item = f64> {
    (0..order).map(move |index| (2.0 * as_f64(index) + 1.0 - as_f64(order)) * PI / (2.0 * as_f64(order)))
}

fn prototype_poles(order: usize) -> Vec<Complex<f64>> {
    half_angles(order).map(|angle| -Complex::from_polar(1.0, angle)).collect()
}

/// Stretches an analogue prototype to the edge, warped, and maps it to the z plane.
fn digital_low_pass(prototype: ZerosPolesGain, edge_hz: f64, rate_hz: f64) -> Sections {
    let ZerosPolesGain { zeros, poles, gain } = prototype;
    // The bilinear transform at sample rate 2: s = 4·(z − 1)/(z + 1).
    let scale = 4.0;
    let warped = scale * (PI * edge_hz / rate_hz).tan();
    let excess = poles.len() - zeros.len();
    let stretched = |roots: &[Complex<f64>]| roots.iter().map(|root| root * warped).collect::<Vec<_>>();
    let (zeros, poles) = (stretched(&zeros), stretched(&poles));
    let powers = i32::try_from(excess).unwrap_or(i32::MAX);
    let distance = |roots: &[Complex<f64>]| roots.iter().map(|root| scale - root).product::<Complex<f64>>();
    let gain = gain * warped.powi(powers) * (distance(&zeros) / distance(&poles)).re;
    let mapped = |roots: &[Complex<f64>]| roots.iter().map(|root| (root + scale) / (-root + scale)).collect::<Vec<_>>();
    let mut zeros = mapped(&zeros);
    zeros.resize(poles.len(), Complex::new(-1.0, 0.0));
    Sections::from_zeros_poles(&zeros, &mapped(&poles), gain)
}

#[allow(clippy::cast_precision_loss, reason = "filter orders are small")]
fn as_f64(number: usize) -> f64 {
    number as f64
}
