//! What the page of a rendering is made of.

use dynamics::Model;
use identification::Fit;
use identification::diagnosis::Verdict;
use serde::Serialize;

use crate::CaptureFacts;

/// A rendered knob beside its model with everything shown on the page.
#[derive(Clone, Debug)]
pub struct RenderingPage<'a> {
    /// The model that was to be felt; its name is the page's title.
    pub intended: &'a Model,
    /// The fit of the rendered knob's capture.
    pub fit: &'a Fit,
    /// That capture.
    pub capture: CaptureFacts,
    /// Names of all captures that were made.
    pub sources: Vec<String>,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// The model's parameters, intended and rendered.
    pub parameters: Vec<RenderedParameter>,
    /// Largest difference of a parameter that passes outside its interval, %.
    pub largest_difference_percent: f64,
    /// The same for what the knob bears at rest, %.
    pub largest_static_difference_percent: f64,
    /// RMS of rendered minus intended torque while the knob slides, mNm.
    pub torque_error_rms_mnm: f64,
    /// RMS of the intended torque there, mNm.
    pub torque_rms_mnm: f64,
    /// Their ratio, %.
    pub torque_error_percent: f64,
    /// The largest that passes, %.
    pub largest_torque_error_percent: f64,
    /// The knob held inside its stick band; `None` where it bears nothing at rest.
    pub held_still: Option<HeldStill>,
    /// What the rendering adds; `None` where that is not known.
    pub added: Option<AddedByRendering>,
    /// What a reader should know, in sentences.
    pub notes: Vec<String>,
    /// Whether all of it passed.
    pub passed: bool,
}

/// One parameter of a rendered knob.
#[derive(Clone, Debug, Serialize)]
pub struct RenderedParameter {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value in the model.
    pub intended: f64,
    /// Its value in the rendered knob; `None` where the captures do not determine it.
    pub rendered: Option<f64>,
    /// The 95 % interval of the rendered value.
    pub ci95: Option<[f64; 2]>,
    /// 100 · (rendered / intended − 1); for a phase, its error as a share of a period.
    pub difference_percent: Option<f64>,
    /// Whether the interval holds the intended value or the difference is small enough; `None` where there is no value.
    pub passed: Option<bool>,
    /// Why there is no value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// How still a sticking knob is held.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct HeldStill {
    /// The hand's torque, mNm.
    pub torque_mnm: f64,
    /// For how long, s.
    pub duration_s: f64,
    /// Steps of the encoder between its lowest and its highest reading.
    pub encoder_steps: f64,
}

/// The verdict of a diagnosis that starts from the intended model.
#[derive(Clone, Debug, Serialize)]
pub struct AddedByRendering {
    /// `none`, `effects` or `outside-library`.
    pub verdict: Verdict,
    /// Names of effects, strongest first.
    pub effects: Vec<String>,
    /// RMS on the capture held out before them, mNm.
    pub heldout_rms_before: f64,
    /// RMS after them, mNm.
    pub heldout_rms_after: f64,
    /// What the sensors' noise alone would leave, mNm.
    pub noise_floor_rms: f64,
}
