//! The data sheet of a control: from a curve of load over position to the figures in which the trade speaks of it.
//!
//! A [`Curve`](archive::testers::Curve) is torque over angle or force over travel, turned or pressed slowly enough for speed to
//! have no part in it. [`Sheet::of`] takes one curve, or several of one part, to
//!
//! - *branches*: the load over the position, one a direction, with intervals;
//! - *figures*: collapse, valley and snap of what is pressed; pitch, peak, trough, stiffness, energy and backlash of detents, and
//!   the friction between the branches.
//!
//! Every figure has a [`FigureKind`], which defines it in a sentence and says whose definition that is, and a 95 % interval. For
//! one curve the interval comes from the noise about the smoothed curve; for several it is the interval that holds the figure of
//! one further curve. A [`Specification`] sets limits on figures and curve; [`Specification::judge`] says pass, fail or
//! undecided. [`Capability`] and [`Gauge`] tell of many parts, operators and repeats.

mod branch;
mod capability;
mod dynamic;
mod figure;
mod figures_csv;
mod gauge;
mod noise;
pub mod perception;
mod pressed;
mod qdas;
mod quantiles;
mod repeats;
mod rotary;
mod specification;
mod verdict;

pub use branch::Branch;
pub use capability::{Capability, CapabilityError, Index};
pub use figure::{Figure, FigureKind, Spread, kinds};
pub use figures_csv::FIGURES_HEADER;
pub use gauge::{Design, Gauge, GaugeError};
pub use qdas::{QDAS_REMARK, QdasRow, qdas};
pub use repeats::{CurveError, Detent, DetentFigure, Sheet, SheetError, kinds_of};
pub use specification::{Limits, Specification, SpecificationError};
pub use verdict::{EnvelopeVerdict, FigureVerdict, Judgement, Verdict};
