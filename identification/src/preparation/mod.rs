//! From samples to rows: one even grid of time, faulty stretches left out, motion from both sensors, mask and filter.
//!
//! Takes [`Samples`](crate::Samples) with what is known of the rig. Gives a [`Prepared`] capture, whose [`RowMask`] makes rows
//! of torque and of any column alike, and what the sensors' noise adds to sums over these ([`SensorNoise`]).

mod central_differences;
mod derivative;
mod fusion;
mod knob_motion;
mod motion;
mod paper;
mod prepared;
mod row_mask;
mod saturation;
mod sensor_noise;
mod spectrum;
mod time_order;
mod uniform;

pub(crate) use derivative::{GRADIENT_REACH, gradient};
pub use knob_motion::knob_motion;
pub(crate) use motion::{Band, KnobMotion, compliance_rad_mnm, knob_angle};
pub(crate) use prepared::Prepared;
pub(crate) use row_mask::{RowMask, fill_columns};
pub(crate) use saturation::Saturation;
pub(crate) use sensor_noise::SensorNoise;
pub(crate) use spectrum::{Spectrum, periodogram};
pub(crate) use time_order::Sorted;
pub(crate) use uniform::{Uniform, advance, lagrange_weights};

use crate::options::{FitOptions, PreparationMethod};
use crate::samples::FitError;

/// A capture prepared as the options ask for it; `exact` is its motion, if the columns hold that.
pub(crate) fn prepare<'a>(
    uniform: &'a Uniform,
    exact: Option<KnobMotion>,
    options: &FitOptions,
) -> Result<Prepared<'a>, FitError> {
    match options.preparation {
        PreparationMethod::Paper => paper::paper_preparation(uniform).checked(),
        PreparationMethod::CentralDifferences => central_differences::central_differences(uniform).checked(),
        PreparationMethod::Automatic => {
            let band = Band::of(uniform, exact.is_some(), options.calibration.as_ref());
            Prepared::in_band(uniform, exact, band, options)
        }
    }
}
