//! What a part must be: limits on figures, and an envelope for the curve.

use std::collections::BTreeMap;

use serde::Deserialize;
use shared_types::{Axis, Quantity};

use crate::figure::{FigureKind, kinds};
use crate::repeats::kinds_of;

/// Largest risk of a wrong verdict where the specification states none.
const RISK: f64 = 0.05;

/// Limits on the figures of a part and on its curve.
///
/// ```
/// let specification = sheet::Specification::from_toml(
///     r#"
///     risk = 0.01
///     [figures.collapse_force]
///     min = 45
///     max = 55
///     unit = "gf"
///     [[envelope]]
///     branch = "press"
///     position = [0.5, 1.0, 2.0]
///     low = [0.2, 0.3, 0.2]
///     high = [0.5, 0.6, 0.5]
///     "#,
/// )?;
/// assert_eq!(specification.limits().len(), 1);
/// # Ok::<(), sheet::SpecificationError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Specification {
    /// What it is of; may be empty.
    pub name: String,
    /// Largest probability that a unit whose figure lies on the other side of a limit is passed, and that one within all limits
    /// is failed.
    pub risk: f64,
    limits: Vec<(&'static FigureKind, Limits)>,
    pub(crate) envelopes: Vec<Envelope>,
}

/// What a figure must lie between, in its unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct Limits {
    /// The least that it may be.
    pub min: Option<f64>,
    /// The most that it may be.
    pub max: Option<f64>,
}

/// What a branch of the curve must lie between.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Envelope {
    pub(crate) branch: String,
    /// Position, least and largest load; in the instrument's units, by position.
    pub(crate) points: Vec<[f64; 3]>,
}

/// What is wrong with a specification.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecificationError {
    /// Not TOML, or not of this form.
    #[error("{0}")]
    Form(String),
    /// No limits at all.
    #[error("it has neither [figures.NAME] with min or max nor an [[envelope]], so nothing could fail")]
    Empty,
    /// A risk that does not lie between 0 and 0.5.
    #[error("risk = {0}, but it must lie between 0 and 0.5")]
    Risk(f64),
    /// There is no such figure.
    #[error("`{0}` is not a figure; known are {1}")]
    Figure(String, String),
    /// A figure without limits, or with limits that nothing lies between.
    #[error("{0}: it needs min, max or both, and min below max")]
    Limits(String),
    /// A unit that is none of the figure.
    #[error("{figure}: `{unit}` is not a unit of it; its unit is `{own}`")]
    Unit {
        /// The figure.
        figure: String,
        /// The unit in the file.
        unit: String,
        /// The figure's own.
        own: &'static str,
    },
    /// A branch that is none, or columns that do not fit together.
    #[error("envelope of `{0}`: {1}")]
    Envelope(String, &'static str),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    name: String,
    risk: Option<f64>,
    #[serde(default)]
    figures: BTreeMap<String, FileLimits>,
    #[serde(default)]
    envelope: Vec<FileEnvelope>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileLimits {
    min: Option<f64>,
    max: Option<f64>,
    unit: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileEnvelope {
    branch: String,
    position: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    position_unit: Option<String>,
    load_unit: Option<String>,
}

impl Specification {
    /// Reads a specification.
    ///
    /// # Errors
    /// [`SpecificationError`], one sentence.
    pub fn from_toml(text: &str) -> Result<Self, SpecificationError> {
        let form = |error: toml::de::Error| SpecificationError::Form(error.message().replace('\n', ", "));
        let File { name, risk, figures, envelope } = toml::from_str(text).map_err(form)?;
        let risk = risk.unwrap_or(RISK);
        if !(risk > 0.0 && risk < 0.5) {
            return Err(SpecificationError::Risk(risk));
        }
        let limits = figures.into_iter().map(|(name, limits)| limits.checked(&name));
        let limits = limits.collect::<Result<Vec<_>, _>>()?;
        let envelopes = envelope.into_iter().map(FileEnvelope::checked).collect::<Result<Vec<_>, _>>()?;
        if limits.is_empty() && envelopes.is_empty() {
            return Err(SpecificationError::Empty);
        }
        Ok(Self { name, risk, limits, envelopes })
    }

    /// The axis of the controls that it is for, from its first limit or else its first envelope.
    #[must_use]
    pub fn axis(&self) -> Axis {
        let of_figure = |kind| {
            if kinds_of(Axis::Linear).iter().any(|one| std::ptr::eq(*one, kind)) { Axis::Linear } else { Axis::Rotary }
        };
        let of_branch = |branch: &str| axis_of(branch).unwrap_or_default();
        let figure = self.limits.first().map(|(kind, _)| of_figure(*kind));
        figure.or_else(|| self.envelopes.first().map(|envelope| of_branch(&envelope.branch))).unwrap_or_default()
    }

    /// The figures that have limits.
    #[must_use]
    pub fn limits(&self) -> &[(&'static FigureKind, Limits)] {
        &self.limits
    }
}

impl FileLimits {
    fn checked(self, name: &str) -> Result<(&'static FigureKind, Limits), SpecificationError> {
        let named = || kinds().filter(|kind| kind.name == name);
        let Some(first) = named().next() else {
            let known: Vec<&str> = kinds().map(|kind| kind.name).collect();
            return Err(SpecificationError::Figure(name.to_owned(), known.join(", ")));
        };
        let found = match &self.unit {
            None => Some((first, 1.0)),
            // Turned and pressed controls have figures of one name.
            Some(unit) => {
                let own = named().find(|kind| kind.unit == unit).map(|kind| (kind, 1.0));
                own.or_else(|| named().find_map(|kind| Some((kind, factor(kind.unit, unit)?))))
            }
        };
        let (kind, factor) = found.ok_or_else(|| SpecificationError::Unit {
            figure: name.to_owned(),
            unit: self.unit.clone().unwrap_or_default(),
            own: first.unit,
        })?;
        let limits = Limits { min: self.min.map(|min| min * factor), max: self.max.map(|max| max * factor) };
        let sensible = match (limits.min, limits.max) {
            (Some(min), Some(max)) => min < max,
            (None, None) => false,
            (Some(one), None) | (None, Some(one)) => one.is_finite(),
        };
        if sensible { Ok((kind, limits)) } else { Err(SpecificationError::Limits(name.to_owned())) }
    }
}

/// The axis that has such a branch.
fn axis_of(branch: &str) -> Option<Axis> {
    match branch {
        "press" | "return" => Some(Axis::Linear),
        "positive" | "negative" => Some(Axis::Rotary),
        _ => None,
    }
}

/// The size of a unit in a figure's own.
fn factor(own: &str, unit: &str) -> Option<f64> {
    use Quantity::{Angle, Energy, Force, Number, Time, Torque, Travel};
    // Energy first, since `N mm` is a unit of torque, too.
    let of = [Energy, Angle, Torque, Travel, Force, Time, Number]
        .into_iter()
        .find(|quantity| quantity.factor(own).is_some())?;
    Some(of.factor(unit)? / of.factor(own)?)
}

impl FileEnvelope {
    fn checked(self) -> Result<Envelope, SpecificationError> {
        let Self { branch, position, low, high, position_unit, load_unit } = self;
        let wrong = |reason| SpecificationError::Envelope(branch.clone(), reason);
        let axis =
            axis_of(&branch).ok_or_else(|| wrong("there are the branches press, return, positive and negative"))?;
        if position.len() < 2 || low.len() != position.len() || high.len() != position.len() {
            return Err(wrong("position, low and high need two numbers or more, each as many as the others"));
        }
        let size = |quantity: Quantity, unit: Option<String>| {
            unit.map_or(Some(1.0), |unit| quantity.factor(&unit)).ok_or_else(|| wrong("it has an unknown unit"))
        };
        let (position_size, load_size) = (size(axis.position(), position_unit)?, size(axis.load(), load_unit)?);
        let points: Vec<[f64; 3]> = position
            .iter()
            .zip(low.iter().zip(&high))
            .map(|(at, (low, high))| [at * position_size, low * load_size, high * load_size])
            .collect();
        if !points.windows(2).all(|pair| pair[0][0] < pair[1][0]) || !points.iter().all(|[_, low, high]| low < high) {
            return Err(wrong("positions must increase, and low must be below high"));
        }
        Ok(Envelope { branch, points })
    }
}
