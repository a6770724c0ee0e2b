//! What a knob is, in numbers: effects, models, excitations, forward simulation.
//!
//! A [`Model`] is a list of [`Effect`]s. Equation 1 of Swindells and MacLean, *Capturing the
//! Dynamics of Mechanical Knobs* (World Haptics 2007), is the list inertia, friction, detent:
//!
//! ```text
//! τ = M·θ̈ + [θ̇<0]·(−C₋ + B₋·θ̇) + [θ̇>0]·(C₊ + B₊·θ̇) + A·sin(θ/P + S)
//! ```
//!
//! with τ the torque that the knob takes from whoever turns it, positive towards positive angle.
//! Units: rad, rad/s, rad/s², mNm, s.
//!
//! An effect is one file in [`effects`]: its standard name, its parameters with units, its source,
//! its torque and its columns in a fit. Simulation, fit, diagnosis and replay read the same list.
//!
//! ```
//! use dynamics::{Motion, knobs};
//!
//! let knob = knobs::paper_knob(3)?;
//! let motion = Motion { velocity_rad_s: 1.0, acceleration_rad_s2: 10.0, ..Motion::default() };
//! let torque_mnm = knob.torque_mnm(&motion);
//! assert!((torque_mnm - (0.35 + 2.3 - 0.24 + 1.1 * 0.16_f64.sin())).abs() < 1e-12);
//! # Ok::<(), dynamics::ModelError>(())
//! ```

mod axis;
mod bristles;
mod calibration;
mod composition;
mod coupling;
mod effect;
mod effect_kind;
pub mod effects;
pub mod excitation;
mod hypothesis;
mod interned;
pub mod knobs;
mod model;
mod motion;
mod prediction;
mod role;
mod rounded_times;
mod shift;
pub mod simulate;
mod sorted_effects;
mod stiffness;
mod toml_file;
mod torque_table;

pub use axis::{Axis, Quantity};
pub use bristles::Bristles;
pub use calibration::{Calibration, CalibrationError, CoggingHarmonic};
pub use composition::{Composition, CompositionError, CompositionNote, Parts, Source, composition_notes};
pub use coupling::Coupling;
pub use effect::Effect;
pub use effect_kind::{
    Coordinate, Direction, EffectKind, MAX_PARAMETERS, Minimum, ParameterKind, Part, Regressors, StickLimits, TableUse,
    printed_unit, spaced_unit,
};
pub use excitation::{Drive, Excitation, Setpoint};
pub use hypothesis::{Hypothesis, RangeEnd, Scene, Search};
pub use model::Model;
pub use motion::Motion;
pub use prediction::TorqueReader;
pub use role::Role;
pub use rounded_times::even_times;
pub use shift::shifted;
pub use simulate::inner_body::Resolution;
pub use toml_file::ModelError;
pub use torque_table::{Curve, TorqueTable, TorqueTableError};
