//! The options of a fit.

use dynamics::{Axis, Calibration, Effect};

/// The options of a fit, all of which have defaults.
#[derive(Clone, Debug, Default)]
pub struct FitOptions {
    /// What is known of the rig: zeros, delays, compliance and the gripper's inertia, which are taken out.
    pub calibration: Option<Calibration>,
    /// Effects to fit besides inertia, friction and detents; their searched parameters start at the values given.
    pub further_effects: Vec<Effect>,
    /// Fit without looking for detents.
    pub without_detents: bool,
    /// Measure the torque over the angle, one branch a direction, in place of detents, which a pressed control does not have.
    pub characteristic: bool,
    /// Whether the samples are a curve of torque over angle, in which time has no part.
    pub is_quasi_static: bool,
    /// Whether the knob turns; [`Fit::model`](crate::Fit::model) says so.
    pub axis: Axis,
    /// How the capture is filtered before the fit.
    pub preparation: PreparationMethod,
    /// Where the acceleration comes from.
    pub acceleration: AccelerationUse,
}

/// How a capture is filtered before the fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum PreparationMethod {
    /// Every cut-off frequency from the signals' own spectra.
    ///
    /// Mask first, then one linear-phase filter over torque and all columns.
    #[default]
    Automatic,
    /// As Swindells and MacLean 2007 did.
    ///
    /// So that fits compare like with like: velocity through a 10th-order
    /// Butterworth low-pass (500 Hz), then θ, θ̇, θ̈ and τ each through a 3rd-order Chebyshev low-pass of the second
    /// kind with 20 dB and the edges 1, 1, 0.5 and 0.5 kHz; all without phase shift. The acceleration is the
    /// accelerometer's, the twist of the torque sensor stays in, and every sliding sample is a row.
    Paper,
    /// Angle through a 100 Hz Butterworth low-pass, differenced twice, decimated to 100 Hz: common for robots.
    ///
    /// So that fits compare with published figures (A. Janot, M. Gautier,
    /// M. Brunot, Data Set and Reference Models of EMPS, Workshop on Nonlinear System Identification Benchmarks,
    /// Eindhoven 2019): angle through a 4th-order Butterworth low-pass (100 Hz) without phase shift, velocity and
    /// acceleration by plain central differences, 50 ms cut off at each end, then torque and all columns through an
    /// 8th-order Chebyshev low-pass of the first kind (0.05 dB, 40 Hz, both ways) and decimated to 100 Hz. Nothing is left out
    /// at reversals, and no delay is allowed for.
    CentralDifferences,
}

impl PreparationMethod {
    /// The name of the method, as [`Preparation::method`](crate::Preparation::method) tells it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Automatic => "automatic",
            Self::Paper => "paper",
            Self::CentralDifferences => "central-differences",
        }
    }
}

/// Where the acceleration comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AccelerationUse {
    /// Encoder and accelerometer, each where it is quieter; what their noise does to the inertia is taken off.
    #[default]
    Best,
    /// The encoder's second derivative alone.
    Encoder,
}
