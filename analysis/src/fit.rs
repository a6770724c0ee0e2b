//! Fits, and what `fit --json` tells of them.

use dynamics::Model;
use identification::{Average, Fit, FitOptions, PreparationMethod};
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, FigureNumbers, FitNumbers};
use serde::Serialize;

use crate::{AnalysisError, facts, title};

/// Fits a capture with all that is known of its rig.
///
/// # Errors
/// [`AnalysisError::Fit`], one sentence on why nothing can be told from it.
pub fn fit(loaded: &LoadedCapture, preparation: PreparationMethod) -> Result<Fit, AnalysisError> {
    let options = FitOptions { preparation, ..fit_options(loaded) };
    fit_with(loaded, &options)
}

/// What a fit is told of a capture: what is known of its rig, and whether it has detents to look for.
#[must_use]
pub fn fit_options(loaded: &LoadedCapture) -> FitOptions {
    let axis = loaded.capture.axis;
    FitOptions {
        calibration: loaded.calibration.clone(),
        characteristic: !axis.is_rotary(),
        is_quasi_static: loaded.is_quasi_static,
        axis,
        ..FitOptions::default()
    }
}

/// Fits a capture as it is told.
///
/// # Errors
/// [`AnalysisError::Fit`], one sentence on why nothing can be told from it.
pub fn fit_with(loaded: &LoadedCapture, options: &FitOptions) -> Result<Fit, AnalysisError> {
    identification::fit(&loaded.samples(), options)
        .map_err(|reason| AnalysisError::Fit { capture: loaded.capture.source.clone(), reason })
}

/// What is told of the fit of one capture.
#[derive(Serialize)]
pub struct ToldFit<'a> {
    #[serde(flatten)]
    fit: &'a Fit,
    #[serde(flatten)]
    numbers: FitNumbers,
    /// The capture that was fitted.
    capture: CaptureFacts,
    /// The numbers in the captions of the page's figures, where a page was asked for.
    #[serde(skip_serializing_if = "FigureNumbers::is_empty")]
    figures: FigureNumbers,
}

impl<'a> ToldFit<'a> {
    /// Of the fit of this capture, and of the figures on its page.
    #[must_use]
    pub fn of(loaded: &LoadedCapture, fit: &'a Fit, figures: FigureNumbers) -> Self {
        let numbers = FitNumbers::of(fit, loaded.truth.as_ref());
        Self { fit, numbers, capture: facts(loaded), figures }
    }
}

/// What is told of several captures: their mean, then each by itself.
#[derive(Serialize)]
pub struct ToldAverage<'a> {
    #[serde(flatten)]
    average: &'a Average,
    #[serde(flatten)]
    numbers: FitNumbers,
    fits: Vec<ToldFit<'a>>,
}

impl<'a> ToldAverage<'a> {
    /// Of the mean, and of the captures with the fits that it was made of.
    #[must_use]
    pub fn of(average: &'a Average, loaded: &[&LoadedCapture], fits: &'a [Fit]) -> Self {
        let told = loaded.iter().zip(fits).map(|(one, fit)| ToldFit::of(one, fit, FigureNumbers::new()));
        Self { average, numbers: FitNumbers::of(&average.fit, common_truth(loaded)), fits: told.collect() }
    }
}

/// The model that a simulated rig turned in all of the captures; `None` where it was not one.
#[must_use]
pub fn common_truth<'a>(loaded: &[&'a LoadedCapture]) -> Option<&'a Model> {
    let first = loaded.first().and_then(|one| one.truth.as_ref());
    first.filter(|_| loaded.iter().all(|one| one.truth.as_ref() == first))
}

/// What several captures together are called.
#[must_use]
pub fn titles(loaded: &[&LoadedCapture]) -> String {
    let titles: Vec<String> = loaded.iter().map(|one| title(one)).collect();
    titles.join(" and ")
}
