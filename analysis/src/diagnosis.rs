//! Diagnoses, and what `diagnose --json` tells of them.

use dynamics::Model;
use identification::diagnosis::{self, CommandedTorque, DiagnoseOptions, Diagnosis, Progress};
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, DiagnosisNumbers, DiagnosisPage, FigureNumbers};
use serde::Serialize;

use crate::AnalysisError;
use crate::error::{common_axis, same_axis};

/// Finds what a model lacks, using all that is known of the rig. The default model has inertia, friction and detents. The captures
/// exchange their roles if the missing effects can be named only so.
///
/// # Errors
/// [`AnalysisError`], why there can be no meaningful verdict, in one sentence.
pub fn diagnose(
    train: &LoadedCapture,
    heldout: Option<&LoadedCapture>,
    model: Option<Model>,
    progress: Option<&(dyn Fn(Progress) + Sync)>,
) -> Result<Diagnosis, AnalysisError> {
    let samples = heldout.map(LoadedCapture::samples);
    let options = options(None, train, heldout, model, progress)?;
    Ok(diagnosis::diagnose_either_way(&train.samples(), samples.as_ref(), &options)?)
}

/// Like [`diagnose`], but the captures keep their roles. The next experiment may move the control at most `reach_rad` from the start.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_in_these_roles(
    reach_rad: Option<f64>,
    train: &LoadedCapture,
    heldout: &LoadedCapture,
    model: Option<Model>,
    progress: Option<&(dyn Fn(Progress) + Sync)>,
) -> Result<Diagnosis, AnalysisError> {
    let options = options(reach_rad, train, Some(heldout), model, progress)?;
    Ok(diagnosis::diagnose(&train.samples(), Some(&heldout.samples()), &options)?)
}

fn options<'a>(
    reach_rad: Option<f64>,
    train: &'a LoadedCapture,
    heldout: Option<&'a LoadedCapture>,
    model: Option<Model>,
    progress: Option<&'a (dyn Fn(Progress) + Sync)>,
) -> Result<DiagnoseOptions<'a>, AnalysisError> {
    common_axis([Some(train), heldout].into_iter().flatten().map(|one| one.capture.axis))?;
    model.iter().try_for_each(|model| same_axis(model, train))?;
    let of = |loaded: &'a LoadedCapture| {
        Some(CommandedTorque { torque_mnm: loaded.commanded_torque_mnm()?, t_s: &loaded.capture.t_s })
    };
    let commanded = of(train).zip(of(heldout.unwrap_or(train))).map(Into::into);
    let calibration = train.calibration.clone();
    Ok(DiagnoseOptions { calibration, axis: train.capture.axis, model, commanded, progress, reach_rad })
}

/// Refuses a model that a diagnosis cannot start from, under the name that its owner knows it by.
///
/// # Errors
/// [`AnalysisError::Drawn`].
pub fn refuse_drawn(model: &Model, called: &str) -> Result<(), AnalysisError> {
    let drawn = model.effects.iter().find(|effect| effect.table().is_some());
    drawn.map_or(Ok(()), |drawn| Err(AnalysisError::Drawn { model: called.to_owned(), effect: drawn.kind().name }))
}

/// The model that a diagnosis of captures, one at least, came to.
#[must_use]
pub fn diagnosed_model(found: &Diagnosis, captures: &[&LoadedCapture]) -> Model {
    let axis = captures[0].capture.axis;
    let sources: Vec<String> = captures.iter().map(|one| one.capture.source.display().to_string()).collect();
    Model {
        name: captures[0].title(),
        description: format!("diagnosed from {}: {}", sources.join(", "), axis.words(&found.summary)),
        effects: found.model.effects.iter().map(|effect| effect.without_origin()).collect(),
        axis,
    }
}

/// The result of a diagnosis, as `diagnose --json` writes it.
#[derive(Serialize)]
pub struct DiagnosisResult<'a> {
    #[serde(flatten)]
    found: &'a Diagnosis,
    #[serde(flatten)]
    numbers: DiagnosisNumbers,
    /// The capture that models were fitted to.
    train: &'a CaptureFacts,
    /// The held-out capture, if it is a separate one.
    heldout: Option<&'a CaptureFacts>,
    /// The numbers in the captions of the page's figures, where a page was asked for.
    #[serde(skip_serializing_if = "FigureNumbers::is_empty")]
    figures: FigureNumbers,
}

impl<'a> DiagnosisResult<'a> {
    /// The result shown on a page, with the numbers of its figures.
    #[must_use]
    pub fn of(page: &'a DiagnosisPage<'a>, figures: FigureNumbers) -> Self {
        let DiagnosisPage { found, train, heldout } = page;
        Self { found, numbers: DiagnosisNumbers::of(found), train, heldout: heldout.as_ref(), figures }
    }
}
