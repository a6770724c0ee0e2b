//! From a capture to a model: the mathematics of the instrument.
//!
//! The problem in symbols. A capture is torque τ and motion (θ, θ̇, θ̈) at times tₙ. A model is a sum of
//! effects, and every effect is a sum of columns:
//!
//! ```text
//! τ(tₙ) = Σⱼ cⱼ · xⱼ(θₙ, θ̇ₙ, θ̈ₙ; p) + noise
//! ```
//!
//! The *coefficients* c are linear; the few *searched* parameters p, on which columns themselves depend
//! (the detent period), are not. [`fit`] solves this without a starting point:
//!
//! 1. The motion comes from the encoder, low-passed without phase shift where its signal sinks into its
//!    noise, and differentiated; an accelerometer takes part above the frequency from which it is quieter.
//! 2. Samples where the knob may stick are multiplied by zero in the torque *and in every column*, then
//!    all pass one zero-phase low-pass and are decimated: the relation stays exactly linear.
//! 3. Base effects by linear least squares with Coulomb friction at or above zero; the detent period by
//!    a scan over everything that the travel supports, refined by Gauss–Newton.
//! 4. What the sensors' own noise adds to the normal equations is subtracted: it would bias the inertia.
//! 5. 95 % intervals allow for autocorrelated and heteroscedastic residuals, and for the fit having made the residuals
//!    smaller than the errors.
//!
//! [`live::LiveFit`] does the same with a stream. [`average()`] combines several captures into one model,
//! [`calibration`] calibrates a rig from captures, and [`checks`] examines a capture without a fit.

mod average;
pub mod calibration;
pub mod checks;
mod detents;
pub mod diagnosis;
mod estimate;
mod fit;
mod karnopp;
pub mod live;
mod numerics;
mod options;
mod preparation;
mod quasi_static;
mod regression;
mod samples;
mod sinusoids;

pub use average::{Agreement, Average, Estimated, Repeatability, average};
pub use estimate::{Covariance, Fit, Harmonic, Parameter, Parameters, Point, Preparation};
pub use fit::fit;
pub use numerics::statistics;
pub use options::{AccelerationUse, FitOptions, PreparationMethod};
pub use preparation::encoder_step::encoder_step;
pub use preparation::filter;
pub use preparation::motion::knob_motion;
pub use regression::characteristic::{CharacteristicPoint, MeasuredCurve};
pub use samples::{FEWEST_SAMPLES, FitError, Samples};
