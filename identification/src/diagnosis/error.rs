//! Why captures cannot be diagnosed.

use crate::FitError;

/// Why captures cannot be diagnosed.
#[derive(Debug, thiserror::Error)]
pub enum DiagnosisError {
    /// One of the captures cannot be fitted.
    #[error("the {which} capture: {reason}")]
    Capture {
        /// Which one.
        which: &'static str,
        /// What is wrong with it.
        reason: FitError,
    },
    /// The captures are the same.
    #[error(
        "the held-out capture is the training capture; give one of another motion, or none to hold out stretches of \
         the training capture"
    )]
    SameCapture,
    /// The columns differ by a power of ten or another unit.
    #[error(
        "the model of the training capture predicts the held-out torque only when multiplied by {factor:.3}; check that \
         both captures are of one knob and in the same units (rad, mNm)"
    )]
    DifferentUnits {
        /// The factor by which the prediction would have to be multiplied.
        factor: f64,
    },
    /// The torque hardly rises above the noise.
    #[error(
        "the {which} capture's torque is {over_floor:.1} times its noise, too quiet to tell anything; turn the knob \
         faster or further"
    )]
    TooQuiet {
        /// Which one.
        which: &'static str,
        /// RMS of the torque in noise floors.
        over_floor: f64,
    },
}
