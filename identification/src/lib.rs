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
//!    noise, and differentiated; above the frequency where an accelerometer is quieter, that takes part.
//! 2. Samples where the knob may stick are multiplied by zero in the torque *and in every column*, then
//!    all pass one zero-phase low-pass and are decimated: the relation stays exactly linear.
//! 3. Base effects by linear least squares with Coulomb friction at or above zero; the detent period by
//!    a scan over everything that the travel supports, refined by Gauss–Newton.
//! 4. What the sensors' own noise adds to the normal equations is taken off them; it would shift the inertia.
//! 5. 95 % intervals allow for residuals that are correlated, of varying size, and smaller than the errors by what the
//!    fit took.
//!
//! [`live::LiveFit`] does the same to a stream. [`average()`] makes one model of several captures,
//! [`calibration`] finds out what is known of a rig, and [`checks`] looks at a capture without a fit.

mod angle_spectrum;
mod average;
mod bends;
pub mod calibration;
mod central_differences;
mod characteristic;
pub mod checks;
mod detents;
pub mod diagnosis;
mod encoder_step;
mod estimate;
pub mod filter;
mod fit;
mod fixed_preparation;
mod fourier;
mod frame;
mod fusion;
mod held_out;
mod karnopp;
mod knob_motion;
mod least_squares;
mod leverage;
pub mod live;
mod long_run;
mod misfit;
mod motion;
mod options;
mod paper_preparation;
mod problem;
mod quasi_static;
mod report;
mod samples;
mod sampling;
mod saturation;
mod scan;
mod sensor_noise;
mod spectrum;
pub mod statistics;
mod time_order;
mod uniform;
mod vector;

pub use average::{Agreement, Average, Repeatability, Told, average};
pub use characteristic::{CharacteristicPoint, MeasuredCurve};
pub use encoder_step::encoder_step;
pub use estimate::{Covariance, Fit, Harmonic, Parameter, Parameters, Point, Preparation};
pub use fit::fit;
pub use knob_motion::knob_motion;
pub use options::{AccelerationUse, FitOptions, PreparationMethod};
pub use samples::{FEWEST_SAMPLES, FitError, Samples};
