//! The noise that an encoder's steps cause in the acceleration.
//!
//! The steps make white noise only if the knob crosses many of them between two samples. While it turns slowly, their error is a
//! sawtooth, whose spectral lines may lie within the band and exceed several times the noise that the spectrum beyond the band
//! suggests. Since the motion is known, its smooth angle is quantised with the same steps once more.

use crate::numerics::derivative::gradient;
use crate::preparation::encoder_step::encoder_step;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;

/// Rows of the acceleration error that the steps of an encoder with these readings cause, rad/s²; `None` where the encoder shows
/// no steps, the motion is exact, or an accelerometer took part.
pub(super) fn acceleration_rows_rad_s2(
    read_rad: &[f64],
    motion: &KnobMotion,
    row_filter: &RowFilter,
) -> Option<Vec<f64>> {
    let step_rad = encoder_step(read_rad).filter(|_| !motion.exact && !motion.accelerometer)?;
    // Offset by half a step, because the smooth angle lies near the readings from which it was computed.
    let read_again = |angle_rad: &f64| ((angle_rad / step_rad).floor() + 0.5) * step_rad - angle_rad;
    let error_rad: Vec<f64> = motion.angle_rad.iter().map(read_again).collect();
    let smooth = motion.smoother(row_filter.rate_hz).filter(&error_rad);
    Some(row_filter.rows(&gradient(&gradient(&smooth, row_filter.rate_hz), row_filter.rate_hz)))
}
