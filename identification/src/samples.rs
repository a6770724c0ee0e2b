//! The samples of a capture, and why they may not do.

use crate::statistics::{median_step, span};
use crate::vector;

/// A capture's columns, borrowed. All have one length.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Time, s, rising.
    pub t_s: &'a [f64],
    /// Encoder angle, rad.
    pub angle_rad: &'a [f64],
    /// Velocity, rad/s. Used only if it is the angle's exact derivative; a filtered one comes late.
    pub velocity_rad_s: Option<&'a [f64]>,
    /// Accelerometer, rad/s².
    pub acceleration_rad_s2: Option<&'a [f64]>,
    /// Torque that the knob takes, mNm.
    pub torque_mnm: &'a [f64],
}

/// Fewest samples from which anything is fitted.
pub const FEWEST_SAMPLES: usize = 200;

/// Why no model at all could be fitted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Columns of different lengths.
    #[error("the column {column} has {found} samples but t_s has {expected}; give columns of one length")]
    Length {
        /// The column.
        column: &'static str,
        /// Its length.
        found: usize,
        /// The length of the time column.
        expected: usize,
    },
    /// Too little data.
    #[error("the capture has {samples} samples, but a fit needs at least {FEWEST_SAMPLES}; capture for longer")]
    TooFewSamples {
        /// The number of samples.
        samples: usize,
    },
    /// A value that is not a number.
    #[error("sample {index} of {column} is not a finite number; remove it or capture again")]
    NotFinite {
        /// The column.
        column: &'static str,
        /// Index of the sample, from 0.
        index: usize,
    },
    /// Time that stands still or runs backwards.
    #[error("time does not rise at sample {index} ({previous_s} s, then {time_s} s); sort the capture by time")]
    TimeNotRising {
        /// Index of the sample, from 0.
        index: usize,
        /// The time before, s.
        previous_s: f64,
        /// The time found, s.
        time_s: f64,
    },
    /// The knob was not turned.
    #[error("the knob did not move (travel {travel_rad} rad over the capture); excite it with a sweep")]
    NoMotion {
        /// Distance between the smallest and the largest angle, rad.
        travel_rad: f64,
    },
    /// The knob moved, but never fast enough to be distinguished from rest.
    #[error(
        "the knob moved faster than {threshold_rad_s} rad/s, where it surely slides, in only {samples} samples; \
         excite it with a faster or longer sweep"
    )]
    HardlyMoving {
        /// Speed above which the knob counts as sliding, rad/s.
        threshold_rad_s: f64,
        /// Samples above it.
        samples: usize,
    },
    /// So much of the torque is at an end of its range that the rest is too little.
    #[error(
        "the torque channel stands at an end of its range for {samples} of {total} samples, and the rest is too little for \
         a fit; excite the knob less, or use a sensor with a wider range"
    )]
    Saturated {
        /// Samples at an end of the range.
        samples: usize,
        /// All samples.
        total: usize,
    },
    /// The torque channel says nothing.
    #[error("the torque is {torque_mnm} mNm throughout; check the torque sensor and its cable")]
    ConstantTorque {
        /// The torque, mNm.
        torque_mnm: f64,
    },
}

impl Samples<'_> {
    /// Sample rate, Hz: that of the median period.
    pub(crate) fn rate_hz(&self) -> f64 {
        1.0 / median_step(self.t_s)
    }

    /// Checks lengths, numbers and time.
    pub(crate) fn check(&self) -> Result<(), FitError> {
        let columns = [
            ("t_s", Some(self.t_s)),
            ("angle_rad", Some(self.angle_rad)),
            ("velocity_rad_s", self.velocity_rad_s),
            ("acceleration_rad_s2", self.acceleration_rad_s2),
            ("torque_mnm", Some(self.torque_mnm)),
        ];
        for (column, values) in columns.iter().filter_map(|(name, values)| values.map(|values| (*name, values))) {
            if values.len() != self.t_s.len() {
                return Err(FitError::Length { column, found: values.len(), expected: self.t_s.len() });
            }
            if !vector::all_finite(values)
                && let Some(index) = values.iter().position(|value| !value.is_finite())
            {
                return Err(FitError::NotFinite { column, index });
            }
        }
        if self.t_s.len() < FEWEST_SAMPLES {
            return Err(FitError::TooFewSamples { samples: self.t_s.len() });
        }
        if !vector::rises(self.t_s)
            && let Some(index) = self.t_s.windows(2).position(|pair| pair[1] <= pair[0])
        {
            return Err(FitError::TimeNotRising {
                index: index + 1,
                previous_s: self.t_s[index],
                time_s: self.t_s[index + 1],
            });
        }
        let travel_rad = span(self.angle_rad);
        if travel_rad <= 0.0 {
            return Err(FitError::NoMotion { travel_rad });
        }
        if span(self.torque_mnm) <= 0.0 {
            return Err(FitError::ConstantTorque { torque_mnm: self.torque_mnm[0] });
        }
        Ok(())
    }
}
