//! `diagnose`: what a model lacks.

use std::path::Path;

use anyhow::bail;
use dynamics::Model;
use identification::diagnosis::{CommandedTorque, DiagnoseOptions, Diagnosis, Progress, diagnose};
use indicatif::{ProgressBar, ProgressStyle};
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, DiagnosisNumbers, DiagnosisPage, FigureNumbers};
use serde::Serialize;

use crate::command_line;
use crate::diagnosis_text;
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::{Kind, to_output, write, write_json};
use crate::recording;

/// Diagnoses a capture and writes what was asked for.
///
/// # Errors
/// One sentence on why no verdict would be worth anything, or what is wrong with a file.
pub fn run(options: &command_line::DiagnoseOptions) -> anyhow::Result<Outcome> {
    let train = load::load(&options.train)?;
    let heldout = options.heldout.as_deref().map(load::load).transpose()?;
    let model = options.model.as_deref().map(starting_model).transpose()?;
    let bar = progress_bar();
    let progress = |progress: Progress| show_progress(&bar, progress);
    let samples = heldout.as_ref().map(LoadedCapture::samples);
    let judge = heldout.as_ref().unwrap_or(&train);
    let commanded = train.commanded_torque_mnm().zip(judge.commanded_torque_mnm());
    let commanded = commanded.map(|(of_train, of_judge)| CommandedTorque {
        train: of_train,
        train_t_s: &train.capture.t_s,
        heldout: of_judge,
        heldout_t_s: &judge.capture.t_s,
    });
    let calibration = train.calibration.clone();
    let asked = DiagnoseOptions { calibration, model, commanded, progress: Some(&progress), reach_rad: None };
    let found = diagnose(&train.samples(), samples.as_ref(), &asked);
    bar.finish_and_clear();
    let found = found?;
    if !to_output(options.json.as_deref()) {
        diagnosis_text::lines(&found).iter().for_each(say);
    }
    if let Some(path) = &options.out {
        let model = Model {
            name: load::title(&train),
            description: format!("diagnosed from {}: {}", options.train.display(), found.summary),
            effects: found.model.effects.iter().map(|effect| effect.without_origin()).collect(),
        };
        write(path, Kind::DiagnosedModel, &model.to_toml())?;
    }
    let page = DiagnosisPage { found: &found, train: load::facts(&train), heldout: heldout.as_ref().map(load::facts) };
    tell(&page, options.json.as_deref(), options.report.as_deref())?;
    if let Some(path) = &options.recording {
        recording::write(path, &found, &load::title(&train), heldout.as_ref().map(load::title).as_deref())?;
    }
    Ok(Outcome::Done)
}

/// What `--json` tells of a diagnosis.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    found: &'a Diagnosis,
    #[serde(flatten)]
    numbers: DiagnosisNumbers,
    /// The capture that models were fitted to.
    train: &'a CaptureFacts,
    /// The capture that they were judged by, if it is another.
    heldout: Option<&'a CaptureFacts>,
    /// The numbers in the captions of the page's figures, where a page was asked for.
    #[serde(skip_serializing_if = "FigureNumbers::is_empty")]
    figures: FigureNumbers,
}

/// Writes a diagnosis as JSON and as a page, what of them was asked for.
///
/// # Errors
/// When a file cannot be written.
pub fn tell(page: &DiagnosisPage<'_>, json: Option<&Path>, report: Option<&Path>) -> anyhow::Result<()> {
    let made = report.map(|path| (path, report::diagnosis_page_with_numbers(page)));
    let figures = made.as_ref().map(|(_, (_, figures))| figures.clone()).unwrap_or_default();
    let DiagnosisPage { found, train, heldout } = page;
    let told = Told { found, numbers: DiagnosisNumbers::of(found), train, heldout: heldout.as_ref(), figures };
    write_json(json, &told)?;
    made.map_or(Ok(()), |(path, (html, _))| write(path, Kind::Page, &html))
}

/// The model to start from.
fn starting_model(path: &Path) -> anyhow::Result<Model> {
    let model = Model::load(path)?;
    match model.effects.iter().find(|effect| effect.table().is_some()) {
        None => Ok(model),
        Some(drawn) => bail!(
            "{} has a {}, which is drawn and cannot be fitted; take it out, its shape will show in what is left",
            path.display(),
            drawn.kind().name
        ),
    }
}

pub fn progress_bar() -> ProgressBar {
    let style =
        ProgressStyle::with_template("{bar:24} {pos}/{len} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(1).with_style(style)
}

pub fn show_progress(bar: &ProgressBar, progress: Progress) {
    match progress {
        Progress::Tried { effect, done, of } => {
            bar.set_length(of as u64);
            bar.set_position(done as u64);
            bar.set_message(effect);
        }
        Progress::Added { effect, heldout_over_floor } => {
            bar.println(format!("added {effect}: {heldout_over_floor:.2} times the noise is left"));
        }
    }
}
