//! The report page of a fit, of several captures and their mean, of several knobs side by side, of a diagnosis, of a
//! rendering beside its model, of a rig without a knob, of a data sheet, or of units against a specification: one HTML file that a person reads, prints and keeps.
//!
//! The page carries its plots as inline SVG and its style in its head: it needs no script, fetches
//! nothing, follows the reader's light or dark scheme on screen and is light on paper.
//!
//! The way of a number through the crate: a figure in `figures` chooses the points and says in a
//! caption what to see; `plot` lays the axes out with `plotters`; `themed_svg` writes every stroke
//! with a class instead of a colour; the style sheet gives the class its colour.

mod average;
mod comparison;
mod diagnosis;
mod figures;
mod intervals;
pub mod numbers;
mod page;
mod parameter_table;
mod plot;
mod preparation;
mod rendering;
mod rig_test;
mod sheet;
mod shown;
mod trend;
mod verdict;

pub use comparison::{
    ComparedCapture, ComparedKnob, ComparedParameters, ComparedQuality, ComparedValue, Comparison, PaperKnob,
    PaperValue,
};
use dynamics::Model;
use identification::diagnosis::Diagnosis;
use identification::{Average, Fit};
pub use parameter_table::{holds, true_value};
pub use rendering::{
    AddedByRendering, HeldStill, LostMotion, RenderedParameter, Rendering, RenderingLimits, RenderingPage,
};
pub use rig_test::{ChannelDifference, ChannelLag, ChannelTrace, RigTest};
pub use sheet::{JudgedUnit, SheetPage, VerdictsPage, WallKnob, WallPage};
pub use shown::{DiagnosisNumbers, FigureNumbers, FitNumbers, ModelValue};
pub use trend::{Drift, Trend, TrendGroup, TrendParameter, TrendPoint};

/// What is known of a capture besides its samples.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct CaptureFacts {
    /// Headline of the page, such as the knob's name.
    pub title: String,
    /// Name of the file that was fitted.
    pub source: String,
    /// The knob, as the operator named it; empty if not known.
    pub knob: String,
    /// The rig; empty if not known.
    pub rig: String,
    /// Date and time of the capture as the reader should see it; empty if not known.
    pub captured_at: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// Duration of the capture, s.
    pub duration_s: f64,
    /// Samples in the capture.
    pub samples: u64,
    /// Ticks that the control loop missed; `None` if the capture does not record it.
    pub missed_ticks: Option<u64>,
    /// Gaps in the recording; `None` if the capture does not record it.
    pub gaps: Option<u64>,
    /// Whether the loop ran with real-time permissions; `None` if the capture does not record it.
    pub real_time: Option<bool>,
    /// Version of the program that made the page.
    pub software_version: String,
}

/// A fit with everything shown on its page.
#[derive(Clone, Debug)]
pub struct FitPage<'a> {
    /// The fit.
    pub fit: &'a Fit,
    /// The capture that was fitted.
    pub capture: CaptureFacts,
    /// The model that a simulated rig turned; `None` on real hardware.
    pub truth: Option<&'a Model>,
}

/// The page as HTML, complete from doctype to end.
///
/// Numbers show the digits that their intervals support. A value that is not finite appears as a
/// dash and its point is left out of the plots.
#[must_use]
pub fn fit_page(page: &FitPage<'_>) -> String {
    fit_page_with_numbers(page).0
}

/// The page of a fit with the numbers in the captions of its figures, by figure and name.
#[must_use]
pub fn fit_page_with_numbers(page: &FitPage<'_>) -> (String, FigureNumbers) {
    let (markup, numbers) = page::fit_page(page);
    (markup.into_string(), numbers)
}

/// Several captures of a knob and their mean with everything shown on their page.
#[derive(Clone, Debug)]
pub struct AveragePage<'a> {
    /// The mean.
    pub average: &'a Average,
    /// The fits that it was made of.
    pub fits: &'a [Fit],
    /// The captures that were fitted, in the same order.
    pub captures: Vec<CaptureFacts>,
    /// The model that a simulated rig turned in all of them; `None` on real hardware.
    pub truth: Option<&'a Model>,
}

/// The page of a mean as HTML, complete from doctype to end: the mean beside each capture, how they repeat, and the
/// torque of each capture.
///
/// Numbers are written as on [`fit_page`].
#[must_use]
pub fn average_page(page: &AveragePage<'_>) -> String {
    average::average_page(page).into_string()
}

/// A diagnosis with everything shown on its page.
#[derive(Clone, Debug)]
pub struct DiagnosisPage<'a> {
    /// The diagnosis.
    pub found: &'a Diagnosis,
    /// The capture that models were fitted to; its title is the page's.
    pub train: CaptureFacts,
    /// The capture that they were judged by; `None` if stretches of the first were held out.
    pub heldout: Option<CaptureFacts>,
}

/// The page of a diagnosis as HTML, complete from doctype to end: the verdict, the gap, where it lies, each effect that was
/// added beside its rivals, what is left, and what to capture next.
///
/// Numbers are written as on [`fit_page`].
#[must_use]
pub fn diagnosis_page(page: &DiagnosisPage<'_>) -> String {
    diagnosis_page_with_numbers(page).0
}

/// The page of a diagnosis with the numbers in the captions of its figures, by figure and name.
#[must_use]
pub fn diagnosis_page_with_numbers(page: &DiagnosisPage<'_>) -> (String, FigureNumbers) {
    let (markup, numbers) = diagnosis::diagnosis_page(page);
    (markup.into_string(), numbers)
}

/// The page of a rendering as HTML, complete from doctype to end: each parameter rendered beside the intended one, the torque error,
/// intended and captured torque over the angle, how still the knob is held, and what the rendering adds.
///
/// Numbers are written as on [`fit_page`].
#[must_use]
pub fn rendering_page(page: &RenderingPage<'_>) -> String {
    rendering::rendering_page(page).into_string()
}

/// The page of several knobs side by side as HTML, complete from doctype to end: the paper's tables, the parameters side by
/// side, the models as curves, each parameter over all captures, and how the captures of a knob repeat.
///
/// Numbers are written as on [`fit_page`].
#[must_use]
pub fn comparison_page(compared: &Comparison) -> String {
    comparison::comparison_page(compared).into_string()
}

/// The page of a rig test as HTML, complete from doctype to end: original minus measured and the lag of each channel beside the
/// paper's, and the signals themselves.
#[must_use]
pub fn rig_test_page(test: &RigTest) -> String {
    test.axis.words(&rig_test::rig_test_page(test).into_string()).into_owned()
}

/// The page of a data sheet as HTML, complete from doctype to end: the curve, its figures with their definitions, and each detent.
///
/// Numbers are written as on [`fit_page`].
#[must_use]
pub fn sheet_page(page: &SheetPage<'_>) -> String {
    sheet::sheet_page(page).into_string()
}

/// The page of units against a specification as HTML, complete from doctype to end: one line a unit, with reasons.
#[must_use]
pub fn verdicts_page(page: &VerdictsPage<'_>) -> String {
    sheet::verdicts_page(page).into_string()
}

/// The page of knobs side by side as HTML, complete from doctype to end: a small curve and a few figures each.
#[must_use]
pub fn wall_page(page: &WallPage) -> String {
    sheet::wall_page(page).into_string()
}

/// The page of a trend as HTML, complete from doctype to end: each parameter over time, by group, and how it drifts.
///
/// Numbers are written as on [`fit_page`].
#[must_use]
pub fn trend_page(trend: &Trend) -> String {
    trend::trend_page(trend).into_string()
}
