//! Fits, and their results as `fit --json` writes them.

use dynamics::Model;
use identification::{Average, Fit, FitOptions, PreparationMethod};
use loaded_capture::LoadedCapture;
use report::{CaptureFacts, FigureNumbers, FitNumbers};
use serde::Serialize;

use crate::{AnalysisError, common_axis, facts};

/// Fits a capture, using what is known about its rig.
///
/// # Errors
/// [`AnalysisError::Fit`], with the reason in one sentence.
pub fn fit(loaded: &LoadedCapture, preparation: PreparationMethod) -> Result<Fit, AnalysisError> {
    let options = FitOptions { preparation, ..fit_options(loaded) };
    fit_with(loaded, &options)
}

/// The options for fitting a capture: its rig's calibration, its axis, and whether to look for detents.
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

/// Fits a capture with the given options.
///
/// # Errors
/// [`AnalysisError::Fit`], with the reason in one sentence.
pub fn fit_with(loaded: &LoadedCapture, options: &FitOptions) -> Result<Fit, AnalysisError> {
    identification::fit(&loaded.samples(), options)
        .map_err(|reason| AnalysisError::Fit { capture: loaded.capture.source.clone(), reason })
}

/// The fit of a capture, or the mean of the fits of several captures of one control; `None` without captures.
///
/// # Errors
/// [`AnalysisError::Fit`], with the reason in one sentence, or [`AnalysisError::TwoAxes`].
pub fn mean_fit<'a>(captures: impl IntoIterator<Item = &'a LoadedCapture>) -> Result<Option<Fit>, AnalysisError> {
    let captures: Vec<&LoadedCapture> = captures.into_iter().collect();
    common_axis(captures.iter().map(|one| one.capture.axis))?;
    let fits = captures.into_iter().map(|loaded| fit_with(loaded, &fit_options(loaded)));
    Ok(identification::average(&fits.collect::<Result<Vec<_>, _>>()?).map(|average| average.fit))
}

/// The result of fitting one capture.
#[derive(Serialize)]
pub struct FitResult<'a> {
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

impl<'a> FitResult<'a> {
    /// The result of this fit, with the numbers of the figures on its page.
    #[must_use]
    pub fn of(loaded: &LoadedCapture, fit: &'a Fit, figures: FigureNumbers) -> Self {
        let numbers = FitNumbers::of(fit, loaded.truth.as_ref());
        Self { fit, numbers, capture: facts(loaded), figures }
    }
}

/// The result of fitting several captures: their mean, then each separately.
#[derive(Serialize)]
pub struct AverageResult<'a> {
    #[serde(flatten)]
    average: &'a Average,
    #[serde(flatten)]
    numbers: FitNumbers,
    fits: Vec<FitResult<'a>>,
}

impl<'a> AverageResult<'a> {
    /// The result of the mean, with each capture's own fit.
    #[must_use]
    pub fn of(average: &'a Average, loaded: &[&LoadedCapture], fits: &'a [Fit]) -> Self {
        let results = loaded.iter().zip(fits).map(|(one, fit)| FitResult::of(one, fit, FigureNumbers::new()));
        Self { average, numbers: FitNumbers::of(&average.fit, common_truth(loaded)), fits: results.collect() }
    }
}

/// The model that a simulated rig turned in all of the captures; `None` if they differ.
#[must_use]
pub fn common_truth<'a>(loaded: &[&'a LoadedCapture]) -> Option<&'a Model> {
    let first = loaded.first().and_then(|one| one.truth.as_ref());
    first.filter(|_| loaded.iter().all(|one| one.truth.as_ref() == first))
}

/// What several captures together are called.
#[must_use]
pub fn titles(loaded: &[&LoadedCapture]) -> String {
    let titles: Vec<String> = loaded.iter().map(|one| one.title()).collect();
    titles.join(" and ")
}
