//! A capture ready to be made rows of.

use std::borrow::Cow;

use super::motion::{Band, KnobMotion};
use super::row_mask::RowMask;
use super::uniform::Uniform;
use crate::options::FitOptions;
use crate::samples::{FEWEST_SAMPLES, FitError};

/// Motion, torque, mask and filter in one band.
pub(crate) struct Prepared<'a> {
    pub(crate) band: Band,
    pub(crate) motion: KnobMotion,
    pub(crate) torque_mnm: Cow<'a, [f64]>,
    pub(crate) row_mask: RowMask,
}

impl<'a> Prepared<'a> {
    /// With every edge from the signals' own spectra, in a band that is given.
    pub(crate) fn in_band(
        uniform: &'a Uniform,
        exact: Option<KnobMotion>,
        band: Band,
        options: &FitOptions,
    ) -> Result<Self, FitError> {
        let calibration = options.calibration.as_ref();
        let motion = exact.unwrap_or_else(|| KnobMotion::measured(uniform, &band, calibration, options.acceleration));
        let row_mask = RowMask::new(uniform, &motion, &band);
        let torque_mnm = motion.alike(&uniform.torque_mnm, uniform.rate_hz);
        Self { band, motion, torque_mnm, row_mask }.checked()
    }

    /// Itself, unless the knob hardly moved.
    pub(super) fn checked(self) -> Result<Self, FitError> {
        let samples = self.row_mask.sliding();
        if samples < FEWEST_SAMPLES / 2 {
            return Err(FitError::HardlyMoving { threshold_rad_s: self.row_mask.threshold_rad_s, samples });
        }
        Ok(self)
    }
}
