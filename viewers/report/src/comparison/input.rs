//! What the page of a comparison is made of; it serialises to what `compare --json` gives.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use dynamics::Model;
use identification::statistics::half_width;
use identification::{Agreement, Repeatability};
use serde::Serialize;
use sheet::perception::PerceivedDifference;

use crate::CaptureFacts;

/// Several knobs side by side.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// The knobs, in the order in which they were first named.
    pub knobs: Vec<ComparedKnob>,
    /// Version of the program that compared them.
    pub software_version: String,
}

/// A parameter by its name.
pub type ComparedParameters = BTreeMap<&'static str, ComparedValue>;

/// One knob: the mean of its captures, or a model.
#[derive(Clone, Debug, Default, Serialize)]
pub struct ComparedKnob {
    /// What it is called.
    pub name: String,
    /// The model file that its values are from; `None` of captures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model_file: Option<String>,
    /// The mean of its captures, the one capture's, or the model's.
    pub parameters: ComparedParameters,
    /// How well the fits follow the captures, all together; `None` of a model.
    #[serde(flatten)]
    pub quality: Option<ComparedQuality>,
    /// The captures, none of a model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub captures: Vec<ComparedCapture>,
    /// Whether the captures agree; `None` of fewer than two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreement: Option<Agreement>,
    /// How each parameter repeats from capture to capture; empty of fewer than two.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub repeatability: BTreeMap<&'static str, Repeatability>,
    /// Detents in a turn; `None` without detents.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detents_per_turn: Option<f64>,
    /// Angle from one detent to the next, degrees; `None` without detents.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detent_spacing_deg: Option<f64>,
    /// What the paper prints of this knob; `None` of a knob that is not the paper's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<PaperKnob>,
    /// How much each parameter differs from the first knob's, in thresholds of perception; empty of the first.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub felt: BTreeMap<&'static str, PerceivedDifference>,
    /// What a reader should know besides.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// The model that the curves are drawn of.
    #[serde(skip)]
    pub model: Option<Model>,
}

/// A value with its interval, or why there is none.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComparedValue {
    /// The value; `None` where the captures do not determine it.
    pub value: Option<f64>,
    /// Its unit.
    pub unit: &'static str,
    /// Its 95 % interval; `None` of a model, and where nothing bounds it.
    pub ci95: Option<[f64; 2]>,
    /// From the value to the farther end of the interval.
    pub ci95_half_width: Option<f64>,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// How well a fit follows its captures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ComparedQuality {
    /// RMS of measured minus model torque, mNm.
    pub residual_rms_mnm: f64,
    /// The same as a share of the measured torque, %.
    pub relative_error_percent: f64,
    /// Mean half width of the model torque's 95 % interval, mNm.
    pub mean_ci95_mnm: f64,
    /// Samples that were captured.
    pub samples: usize,
}

/// One capture with its own fit.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedCapture {
    /// Its number on the page, counted over all knobs from 1.
    pub number: usize,
    /// Its file and how it was made.
    #[serde(flatten)]
    pub facts: CaptureFacts,
    /// Its parameters.
    pub parameters: ComparedParameters,
    /// How well its fit follows it.
    #[serde(flatten)]
    pub quality: ComparedQuality,
}

/// What the paper prints of a knob in its Tables 4 to 6.
#[derive(Clone, Debug, Serialize)]
pub struct PaperKnob {
    /// The knob's number.
    pub number: u32,
    /// Its description in Table 4.
    pub description: &'static str,
    /// Parameters of Tables 5 and 6.
    pub parameters: BTreeMap<&'static str, PaperValue>,
    /// Mean size of the 95 % interval of the fit, as in Table 5, mNm.
    pub mean_ci95_mnm: f64,
}

/// A printed value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PaperValue {
    /// As this project writes it: friction as a magnitude, detents with a positive amplitude.
    pub value: f64,
    /// As the paper prints it.
    pub printed: f64,
    /// Its unit.
    pub unit: &'static str,
}

impl ComparedValue {
    /// A value with its interval, or why there is none.
    #[must_use]
    pub fn new(value: Option<f64>, unit: &'static str, ci95: Option<[f64; 2]>, reason: Option<String>) -> Self {
        let half_width = value.zip(ci95).map(|(value, ci95)| half_width(value, ci95));
        Self { value, unit, ci95, ci95_half_width: half_width, reason }
    }

    /// Whether there is anything to see: models list every parameter of their effects, many of them zero.
    pub(super) fn is_worth_a_row(&self) -> bool {
        self.value != Some(0.0)
    }
}

impl Comparison {
    /// Every parameter that is anything but zero in a knob or in the paper, in the order in which a model lists them.
    pub(super) fn parameter_names(&self) -> Vec<&'static str> {
        let known = dynamics::effects::ALL.iter().flat_map(|effect| effect.parameters);
        known
            .map(|parameter| parameter.name)
            .filter(|name| {
                self.knobs.iter().any(|knob| {
                    knob.parameters.get(name).is_some_and(ComparedValue::is_worth_a_row)
                        || knob.paper.as_ref().is_some_and(|paper| paper.parameters.contains_key(name))
                })
            })
            .collect()
    }
}

impl ComparedKnob {
    /// What its values are: the mean of so many captures, one capture, or a model.
    pub(super) fn origin(&self) -> String {
        match self.captures.len() {
            0 => "model".to_owned(),
            1 => "one capture".to_owned(),
            many => format!("mean of {many} captures"),
        }
    }

    /// How many detents a turn has, and their distance in degrees.
    fn detents(model: &Model) -> Option<[f64; 2]> {
        let amplitude = model.parameter("detent_amplitude").filter(|amplitude| *amplitude != 0.0);
        let spacing_rad = amplitude.and(model.parameter("detent_period")).map(|period_rad| TAU * period_rad.abs());
        spacing_rad.map(|spacing_rad| [TAU / spacing_rad, spacing_rad.to_degrees()])
    }

    /// The knob with the model that its curves are drawn of, and with the values that follow from the model.
    #[must_use]
    pub fn with_model(self, model: Model) -> Self {
        let detents = Self::detents(&model);
        Self {
            detents_per_turn: detents.map(|[per_turn, _]| per_turn),
            detent_spacing_deg: detents.map(|[_, spacing_deg]| spacing_deg),
            model: Some(model),
            ..self
        }
    }

    /// Unit of a parameter, from whichever knob has it.
    pub(super) fn unit(&self, name: &str) -> Option<&'static str> {
        let own = self.parameters.get(name).map(|own| own.unit);
        own.or_else(|| self.paper.as_ref()?.parameters.get(name).map(|printed| printed.unit))
    }
}
