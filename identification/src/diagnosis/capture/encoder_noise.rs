//! The noise that an encoder's steps make of the acceleration.
//!
//! Steps are white noise only if the knob crosses many of them between two samples. While it turns slowly, each step is a tooth of a sawtooth,
//! whose spectral lines may lie within the band and exceed several times the noise that the spectrum beyond the band suggests. Since the
//! motion is known, its smooth angle is quantised with the same steps once more.

use crate::numerics::derivative::gradient;
use crate::preparation::encoder_step::encoder_step;
use crate::preparation::motion::KnobMotion;
use crate::preparation::row_filter::RowFilter;

/// Rows of the acceleration that the steps of an encoder with these readings make, rad/s²; none where it shows no steps, or where an
/// accelerometer took part.
pub(super) fn acceleration_rows_rad_s2(
    read_rad: &[f64],
    motion: &KnobMotion,
    row_filter: &RowFilter,
) -> Option<Vec<f64>> {
    let step_rad = encoder_step(read_rad).filter(|_| !motion.exact && !motion.accelerometer)?;
    // Half a step off, for the smooth angle lies near the readings that it was made of.
    let read_again = |angle_rad: &f64| ((angle_rad / step_rad).floor() + 0.5) * step_rad - angle_rad;
    let error_rad: Vec<f64> = motion.angle_rad.iter().map(read_again).collect();
    let smooth = motion.smoother(row_filter.rate_hz).filter(&error_rad);
    Some(row_filter.rows(&gradient(&gradient(&smooth, row_filter.rate_hz), row_filter.rate_hz)))
}
