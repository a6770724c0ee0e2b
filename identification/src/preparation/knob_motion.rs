//! The knob's motion at every sample of a capture.

use dynamics::{Calibration, Motion};

use super::motion::{Band, KnobMotion};
use super::uniform::Uniform;
use crate::options::AccelerationUse;
use crate::samples::{FitError, Samples};

/// The knob's motion at every sample, prepared as [`fit`](crate::fit()) prepares it: encoder without
/// phase shift, accelerometer where it is quieter, the twist of the torque sensor taken out.
///
/// Gives one [`Motion`] per sample, in rad, rad/s and rad/s², its time in s since the first sample.
///
/// # Errors
/// [`FitError`] for samples that are not a capture of a motion.
pub fn knob_motion(samples: &Samples<'_>, calibration: Option<&Calibration>) -> Result<Vec<Motion>, FitError> {
    samples.check()?;
    let mut uniform = Uniform::of(samples, calibration);
    let exact = KnobMotion::exact(&mut uniform, calibration);
    let band = Band::of(&uniform, exact.is_some(), calibration);
    let motion = exact.unwrap_or_else(|| KnobMotion::measured(&uniform, &band, calibration, AccelerationUse::Best));
    // The grid has more points than the capture where samples were lost: each sample takes its own.
    let mut point = 0;
    let nearest = samples.t_s.iter().map(|&time_s| {
        while point + 1 < motion.time_s.len()
            && (motion.time_s[point + 1] - time_s).abs() <= (motion.time_s[point] - time_s).abs()
        {
            point += 1;
        }
        Motion {
            // What changes with time does since the capture began.
            time_s: time_s - samples.t_s[0],
            angle_rad: motion.angle_rad[point],
            velocity_rad_s: motion.velocity_rad_s[point],
            acceleration_rad_s2: motion.acceleration_rad_s2[point],
        }
    });
    Ok(nearest.collect())
}
