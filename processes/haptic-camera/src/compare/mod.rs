//! `compare`: several captures or knobs side by side, as the paper's Tables 4 to 6 have them.

mod paper;
mod table;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use clap::Args;
use dynamics::{Model, knobs};
use identification::{Fit, Parameter, Parameters};
use loaded_capture::LoadedCapture;
use report::{ComparedCapture, ComparedKnob, ComparedParameters, ComparedQuality, ComparedValue, Comparison};
use sheet::perception::perceived_differences;

use crate::command_line::ColumnOptions;
use crate::fit::fit_capture;
use crate::fit::true_value;
use crate::load;
use crate::outputs::ResultFiles;

#[derive(Debug, Args)]
pub struct CompareOptions {
    /// What to compare: captures, model files, or 1 to 5 for the paper's knobs; captures of one knob are averaged
    #[arg(required = true, value_name = "CAPTURE|MODEL.toml")]
    pub subjects: Vec<String>,
    #[command(flatten)]
    pub columns: ColumnOptions,
    #[command(flatten)]
    pub results: ResultFiles,
}

/// Longest name of a model that stands over a column, letters.
const LONGEST_NAME: usize = 24;

pub fn run(options: &CompareOptions) -> anyhow::Result<()> {
    let compared = compare(&options.subjects, &options.columns)?;
    let mut axes = compared.knobs.iter().filter_map(|knob| knob.model.as_ref()).map(|model| model.axis);
    let axis = axes.next().unwrap_or_default();
    anyhow::ensure!(axes.all(|other| other == axis), "some of these are rotary and some linear; compare one kind");
    options.results.tell(axis, table::lines(&compared), &compared, || report::comparison_page(&compared))
}

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

/// Everything side by side, in the order given; captures of one knob stand together.
fn compare(given: &[String], columns: &ColumnOptions) -> anyhow::Result<Comparison> {
    let mut subjects: Vec<Subject> = Vec::new();
    for name in given {
        if load::names_model(name) {
            subjects.push(Subject::Model(Box::new(of_model(name, knobs::named(name)?))));
            continue;
        }
        let loaded = load::load_measured(&PathBuf::from(name), columns)?;
        let fit = fit_capture(&loaded)?;
        let group = Group::of(&loaded);
        let same = subjects.iter_mut().find_map(|subject| match subject {
            Subject::Captures { group: known, fitted } if group.is_some() && *known == group => Some(fitted),
            _ => None,
        });
        match same {
            Some(fitted) => fitted.push((loaded, fit)),
            None => subjects.push(Subject::Captures { group, fitted: vec![(loaded, fit)] }),
        }
    }
    let knobs = subjects.into_iter().map(|subject| match subject {
        Subject::Model(knob) => Ok(*knob),
        Subject::Captures { group, fitted } => of_captures(group.as_ref(), &fitted),
    });
    let mut compared = Comparison {
        knobs: knobs.collect::<anyhow::Result<Vec<_>>>()?,
        software_version: env!("CARGO_PKG_VERSION").to_owned(),
    };
    feel(&mut compared);
    number(&mut compared);
    name_apart(&mut compared);
    Ok(compared)
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
        let value = Some(true_value(&model, kind.name).unwrap_or(value));
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

fn of_captures(group: Option<&Group>, fitted: &[(LoadedCapture, Fit)]) -> anyhow::Result<ComparedKnob> {
    let fits: Vec<Fit> = fitted.iter().map(|(_, fit)| fit.clone()).collect();
    let capture = |(loaded, fit): &(LoadedCapture, Fit)| ComparedCapture {
        number: 0,
        facts: analysis::facts(loaded),
        parameters: values(&fit.parameters),
        quality: quality(fit),
    };
    let captures: Vec<ComparedCapture> = fitted.iter().map(capture).collect();
    let name = group.map_or_else(|| captures[0].facts.source.clone(), Group::name);
    let (fit, agreement, repeatability) = match fits.as_slice() {
        [only] => (only.clone(), None, BTreeMap::new()),
        several => {
            let average = identification::average(several).context("there is no capture to fit")?;
            (average.fit, average.agreement, average.repeatability)
        }
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
    Ok(knob.with_model(model))
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
