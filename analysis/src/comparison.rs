//! Captures and models side by side, as the paper's Tables 4 to 6 have them and `compare --json` writes them.

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::Path;

use dynamics::{Model, knobs};
use identification::{Fit, Parameter, Parameters, PreparationMethod};
use loaded_capture::LoadedCapture;
use report::{
    ComparedCapture, ComparedKnob, ComparedParameters, ComparedQuality, ComparedValue, Comparison, true_value,
};
use sheet::perception::perceived_differences;

use crate::{AnalysisError, facts, paper};

/// Longest name of a model that stands over a column, letters.
const LONGEST_NAME: usize = 24;

/// What is to be compared, in the order given; captures of one knob stand together.
#[derive(Default)]
pub struct Comparing(Vec<Subject>);

/// A column to be: a model, or the captures of one knob.
enum Subject {
    Model(Box<ComparedKnob>),
    Captures { group: Option<Group>, fitted: Vec<(LoadedCapture, Fit)> },
}

/// What captures of one knob have in common.
#[derive(Clone, PartialEq)]
struct Group {
    /// The knob, as the operator named it.
    knob: String,
    rendered: bool,
    /// The model that a simulated rig turned.
    truth: Option<Model>,
}

impl Group {
    /// `None` of a capture that does not say which knob it is of.
    fn of(loaded: &LoadedCapture) -> Option<Self> {
        let run = loaded.capture.description.as_ref().filter(|run| !run.knob.is_empty())?;
        Some(Self { knob: run.knob.clone(), rendered: loaded.capture.is_rendered(), truth: loaded.truth.clone() })
    }

    fn name(&self) -> String {
        let file = Path::new(&self.knob).file_stem().map_or(self.knob.as_str().into(), OsStr::to_string_lossy);
        let knob = self.knob.parse::<u32>().map_or(file.into_owned(), |number| format!("Knob {number}"));
        if self.rendered { format!("{knob}, rendered") } else { knob }
    }

    /// Whether the paper's knob of that number was mounted: by its name, and on a simulated rig by its model.
    fn is_paper_knob(&self) -> bool {
        let shipped = self.knob.parse().ok().and_then(|number| knobs::paper_knob(number).ok());
        shipped.is_some_and(|shipped| self.truth.as_ref().is_none_or(|truth| truth.effects == shipped.effects))
    }
}

impl Comparing {
    /// Adds a model under the name that was given for it: a file, or a shipped knob's number.
    pub fn add_model(&mut self, file: &str, model: Model) {
        self.0.push(Subject::Model(Box::new(of_model(file, model))));
    }

    /// Adds a capture, by its fit.
    ///
    /// # Errors
    /// [`AnalysisError::Fit`], with the reason in one sentence.
    pub fn add_capture(&mut self, loaded: LoadedCapture) -> Result<(), AnalysisError> {
        let fit = crate::fit(&loaded, PreparationMethod::default())?;
        let group = Group::of(&loaded);
        let same = self.0.iter_mut().find_map(|subject| match subject {
            Subject::Captures { group: known, fitted } if group.is_some() && *known == group => Some(fitted),
            _ => None,
        });
        match same {
            Some(fitted) => fitted.push((loaded, fit)),
            None => self.0.push(Subject::Captures { group, fitted: vec![(loaded, fit)] }),
        }
        Ok(())
    }

    /// Everything side by side.
    #[must_use]
    pub fn comparison(self) -> Comparison {
        let knobs = self.0.into_iter().map(|subject| match subject {
            Subject::Model(knob) => *knob,
            Subject::Captures { group, fitted } => of_captures(group.as_ref(), &fitted),
        });
        let mut compared =
            Comparison { knobs: knobs.collect(), software_version: env!("CARGO_PKG_VERSION").to_owned() };
        feel(&mut compared);
        number(&mut compared);
        name_apart(&mut compared);
        compared
    }
}

/// Tells by how many thresholds of perception each knob differs from the first of them.
fn feel(compared: &mut Comparison) {
    let Some((ComparedKnob { model: Some(reference), .. }, others)) = compared.knobs.split_first_mut() else { return };
    for knob in others {
        let model = knob.model.iter().filter(|model| model.axis == reference.axis);
        knob.felt = model.flat_map(|model| perceived_differences(reference, model)).collect();
    }
}

/// Numbers captures in the order in which they stand, which need not be that in which they were given.
fn number(compared: &mut Comparison) {
    let captures = compared.knobs.iter_mut().flat_map(|knob| &mut knob.captures);
    captures.zip(1..).for_each(|(capture, number)| capture.number = number);
}

/// Puts a number behind names that several knobs have.
fn name_apart(compared: &mut Comparison) {
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for knob in &mut compared.knobs {
        let times = seen.entry(knob.name.clone()).or_default();
        *times += 1;
        if *times > 1 {
            knob.name = format!("{} ({times})", knob.name);
        }
    }
}

fn of_model(file: &str, model: Model) -> ComparedKnob {
    let mut parameters = ComparedParameters::new();
    for (kind, value) in model.parameters() {
        let value = Some(true_value(Some(&model), kind.name, None).unwrap_or(value));
        parameters.insert(kind.name, ComparedValue::new(value, kind.unit, None, None));
    }
    // A fitted model's name is that of its capture; a shipped knob's number is no file.
    let stem = Path::new(file).file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let short = !model.name.is_empty() && model.name.chars().count() <= LONGEST_NAME;
    let name = if short { model.name.clone() } else { stem };
    let knob = ComparedKnob {
        name: format!("{name}, model"),
        model_file: Some(file.to_owned()),
        parameters,
        paper: paper::knob_of(&model),
        ..ComparedKnob::default()
    };
    knob.with_model(model)
}

fn of_captures(group: Option<&Group>, fitted: &[(LoadedCapture, Fit)]) -> ComparedKnob {
    let fits: Vec<Fit> = fitted.iter().map(|(_, fit)| fit.clone()).collect();
    let capture = |(loaded, fit): &(LoadedCapture, Fit)| ComparedCapture {
        number: 0,
        facts: facts(loaded),
        parameters: values(&fit.parameters),
        quality: quality(fit),
    };
    let captures: Vec<ComparedCapture> = fitted.iter().map(capture).collect();
    let name = group.map_or_else(|| captures[0].facts.source.clone(), Group::name);
    let average = if fits.len() > 1 { identification::average(&fits) } else { None };
    let (fit, agreement, repeatability) = match average {
        Some(average) => (average.fit, average.agreement, average.repeatability),
        None => (fits[0].clone(), None, BTreeMap::new()),
    };
    let paper =
        group.filter(|group| !group.rendered && group.is_paper_knob()).and_then(|group| paper::knob(&group.knob));
    let model = fit.model(&name);
    let knob = ComparedKnob {
        name,
        parameters: values(&fit.parameters),
        quality: Some(quality(&fit)),
        captures,
        agreement,
        repeatability,
        paper,
        notes: fit.notes,
        ..ComparedKnob::default()
    };
    knob.with_model(model)
}

fn values(parameters: &Parameters) -> ComparedParameters {
    let value = |found: &Parameter| ComparedValue::new(found.value, found.unit, found.ci95, found.reason.clone());
    parameters.0.iter().map(|found| (found.name, value(found))).collect()
}

fn quality(fit: &Fit) -> ComparedQuality {
    ComparedQuality {
        residual_rms_mnm: fit.residual_rms_mnm,
        relative_error_percent: fit.relative_error_percent,
        mean_ci95_mnm: fit.mean_ci95_mnm,
        samples: fit.samples,
    }
}
