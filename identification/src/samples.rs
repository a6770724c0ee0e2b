//! The samples of a capture, and why they may be unfit for a fit.

use crate::numerics::vector;
use crate::preparation::clock::typical_step;

/// A capture's columns, borrowed. All have one length.
#[derive(Clone, Copy, Debug)]
pub struct Samples<'a> {
    /// Time, s, rising; [`fit`](crate::fit()) sorts samples that are not in its order.
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

/// Samples picked from a capture, in any order.
pub(crate) struct PickedSamples {
    t_s: Vec<f64>,
    angle_rad: Vec<f64>,
    velocity_rad_s: Option<Vec<f64>>,
    acceleration_rad_s2: Option<Vec<f64>>,
    torque_mnm: Vec<f64>,
}

impl PickedSamples {
    pub(crate) fn of(samples: &Samples<'_>, indices: &[usize]) -> Self {
        Self::mapped(samples, |column| indices.iter().map(|index| column[*index]).collect())
    }

    /// Every column of these samples changed in the same way.
    pub(crate) fn mapped(samples: &Samples<'_>, map: impl Fn(&[f64]) -> Vec<f64> + Copy) -> Self {
        Self {
            t_s: map(samples.t_s),
            angle_rad: map(samples.angle_rad),
            velocity_rad_s: samples.velocity_rad_s.map(map),
            acceleration_rad_s2: samples.acceleration_rad_s2.map(map),
            torque_mnm: map(samples.torque_mnm),
        }
    }

    pub(crate) fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.t_s,
            angle_rad: &self.angle_rad,
            velocity_rad_s: self.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.torque_mnm,
        }
    }
}

/// Fewest samples from which anything is fitted.
pub const FEWEST_SAMPLES: usize = 200;

/// Largest magnitude of a measured value, in the column's unit: sums of larger ones' powers overflow.
pub(crate) const LARGEST: f64 = 1e9;
/// Longest capture, s: a little more than a day. Gaps count too, since simulations and plots cover the time between samples.
const LONGEST_S: f64 = 1e5;
/// Slowest rate of samples that are fitted, Hz.
const SLOWEST_HZ: f64 = 0.001;
/// Fastest rate of samples that are fitted, Hz; the length of filters, and so their memory, grows with it.
const FASTEST_HZ: f64 = 1e6;

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
    /// A value beyond what any sensor reads.
    #[error("sample {index} of {column} is {value:.3e}, beyond what any sensor reads; remove it or capture again")]
    Extreme {
        /// The column.
        column: &'static str,
        /// Index of the sample, from 0.
        index: usize,
        /// The value.
        value: f64,
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
    /// Samples that come faster or more slowly than any rig's.
    #[error(
        "the samples come at {rate_hz:.3e} Hz, but a fit takes {SLOWEST_HZ} to {FASTEST_HZ} Hz; give t_s in seconds"
    )]
    Rate {
        /// The rate of most of them, Hz.
        rate_hz: f64,
    },
    /// Samples that lie farther apart than a day.
    #[error(
        "the samples span {span_s:.3e} s, but a capture lasts a day at most; give t_s in seconds, and every capture a file"
    )]
    TooLong {
        /// From the first sample to the last, s.
        span_s: f64,
    },
    /// The knob was not turned.
    #[error("the knob did not move (travel {travel_rad} rad over the capture); excite it with a sweep")]
    NoMotion {
        /// Distance between the smallest and the largest angle, rad.
        travel_rad: f64,
    },
    /// The knob moved, but hardly ever surely.
    #[error(
        "a fit can use only {samples} samples: those away from rests, reversals and gaps, in which the knob moves faster than \
         {threshold_rad_s:.3e} rad/s and surely slides; excite it with a faster or longer sweep, or sample more often"
    )]
    HardlyMoving {
        /// Speed above which the knob counts as sliding, rad/s.
        threshold_rad_s: f64,
        /// Samples above it, away from where the knob may rest and from gaps.
        samples: usize,
    },
    /// A curve of torque over the angle that does not pass through its travel.
    #[error(
        "the curve does not pass through its travel: give at least {FEWEST_SAMPLES} readings that follow each other along the angle, with no \
         part of the travel left out"
    )]
    NoMap,
    /// The torque is at an end of its range for so many samples that too few are left.
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
    /// The samples sorted by time; `None` if they are sorted already, or cannot be: for columns of different lengths, or a time
    /// that is not a number.
    ///
    /// Two samples of one time both stay, for [`Samples::check`] to find.
    pub(crate) fn sorted(&self) -> Option<PickedSamples> {
        let Samples { t_s, angle_rad, velocity_rad_s, acceleration_rad_s2, torque_mnm } = *self;
        let columns = [Some(angle_rad), velocity_rad_s, acceleration_rad_s2, Some(torque_mnm)];
        if vector::rises(t_s)
            || columns.iter().flatten().any(|column| column.len() != t_s.len())
            || t_s.iter().any(|time| !time.is_finite())
        {
            return None;
        }
        let mut order: Vec<usize> = (0..t_s.len()).collect();
        order.sort_by(|a, b| t_s[*a].total_cmp(&t_s[*b]));
        Some(PickedSamples::of(self, &order))
    }

    /// Checks that a fit can take the samples: columns of one length, finite numbers, time that rises, a motion and a torque.
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
            if column != "t_s"
                && vector::extent(values).is_some_and(|(low, high)| low < -LARGEST || high > LARGEST)
                && let Some(index) = values.iter().position(|value| value.abs() > LARGEST)
            {
                return Err(FitError::Extreme { column, index, value: values[index] });
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
        let span_s = self.t_s[self.t_s.len() - 1] - self.t_s[0];
        if span_s > LONGEST_S {
            return Err(FitError::TooLong { span_s });
        }
        let rate_hz = 1.0 / typical_step(self.t_s).0;
        if !(rate_hz >= SLOWEST_HZ && rate_hz.round() <= FASTEST_HZ) {
            return Err(FitError::Rate { rate_hz });
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

/// Distance between the smallest and the largest value.
pub(crate) fn span(values: &[f64]) -> f64 {
    vector::extent(values).map_or(0.0, |(low, high)| high - low)
}
