//! What a figure is: its name, unit and definition, and its value with an interval.

use serde::Serialize;

use crate::{pressed, rotary};

/// A figure of the sheet, as it is defined.
#[derive(Debug, PartialEq, Serialize)]
pub struct FigureKind {
    /// Its name, everywhere.
    #[serde(skip)]
    pub name: &'static str,
    /// Its unit; `share` for a ratio, empty for a number.
    pub unit: &'static str,
    /// What it is, in a sentence.
    pub definition: &'static str,
    /// Whose definition that is.
    pub source: &'static str,
}

/// The source of a definition that nobody else gives.
pub(crate) const OURS: &str = "this project";

/// Defines the figures of a kind of control: constant, name, unit, source and definition of each.
macro_rules! define_figures {
    ($($constant:ident $name:literal $unit:literal $source:ident $definition:literal)*) => {
        $(pub(super) static $constant: FigureKind =
            FigureKind { name: $name, unit: $unit, source: $source, definition: $definition };)*
        /// Every figure, in the order of the sheet.
        pub(crate) static KINDS: &[&FigureKind] = &[$(&$constant),*];
    };
}
pub(crate) use define_figures;

/// Every figure that there is, in the order of the sheet: pressed controls first, then turned ones.
pub fn kinds() -> impl Iterator<Item = &'static FigureKind> {
    pressed::KINDS.iter().chain(rotary::KINDS).copied()
}

/// A figure of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Figure {
    /// Its value in the kind's unit; `None` where the curve does not determine it.
    pub value: Option<f64>,
    /// Its 95 % interval.
    pub ci95: Option<[f64; 2]>,
    /// Its definition.
    #[serde(flatten)]
    pub kind: &'static FigureKind,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// How the values of several detents differ.
    #[serde(flatten)]
    pub over: Option<Spread>,
    /// Standard deviation of the error that the interval allows for.
    #[serde(skip)]
    pub standard_error: f64,
    /// Degrees of freedom of the standard error; infinite if it comes from the noise within a curve.
    #[serde(skip)]
    pub degrees_of_freedom: f64,
}

/// How the values of several detents differ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// Standard deviation of the values.
    pub spread: f64,
    /// The value farthest from the mean.
    pub worst: f64,
    /// How many there are.
    pub number: usize,
}

/// A value from one curve, with the standard deviation of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) value: f64,
    pub(crate) standard_error: f64,
}

impl Figure {
    /// A value with its standard error, which is known from so many differences.
    pub(crate) fn estimated(kind: &'static FigureKind, estimate: Estimate, degrees_of_freedom: f64) -> Self {
        let Estimate { value, standard_error } = estimate;
        let half = identification::statistics::student_95(degrees_of_freedom) * standard_error;
        Self {
            value: Some(value),
            ci95: Some([value - half, value + half]),
            kind,
            reason: None,
            over: None,
            standard_error,
            degrees_of_freedom,
        }
    }

    /// No value.
    pub(crate) fn undetermined(kind: &'static FigureKind, reason: String) -> Self {
        Self {
            value: None,
            ci95: None,
            kind,
            reason: Some(reason),
            over: None,
            standard_error: f64::NAN,
            degrees_of_freedom: f64::NAN,
        }
    }
}
