//! What the page of a rendering is made of.

use std::path::PathBuf;

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
    /// How the two compare.
    pub rendering: Rendering,
}

/// How a rendered knob compares with its model, as `replay --verify --json` writes it.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Rendering {
    /// The model's name.
    pub model: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// The captures made for it: two sweeps, a creep, and a hold if the knob sticks.
    pub captures: Vec<PathBuf>,
    /// The model's parameters, intended and rendered.
    pub parameters: Vec<RenderedParameter>,
    /// RMS of rendered minus intended torque while the knob slides, mNm.
    pub torque_error_rms_mnm: f64,
    /// RMS of the intended torque there, mNm.
    pub torque_rms_mnm: f64,
    /// Their ratio, %.
    pub torque_error_percent: f64,
    /// The gap of a model with lost motion; `None` for one without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lost_motion: Option<LostMotion>,
    /// The knob held by a torque inside its stick band; `None` where it bears none at rest.
    pub held_still: Option<HeldStill>,
    /// What the rendering adds to the model; `None`, with the reason in `notes`, where that is not known.
    pub added: Option<AddedByRendering>,
    /// What passes.
    pub limits: RenderingLimits,
    /// What a reader of the numbers should know, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether all of it is within what passes: parameters, torque, and how still the knob is held.
    pub passed: bool,
    /// The capture of the rendered knob that was fitted.
    pub capture: CaptureFacts,
}

/// What passes.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct RenderingLimits {
    /// Largest difference of a parameter whose interval does not hold the intended value, %.
    pub difference_percent: f64,
    /// The same for what the knob bears at rest, %.
    pub static_difference_percent: f64,
    /// Largest torque error, %.
    pub torque_error_percent: f64,
}

/// The gap of a rendered knob, as it shows without a fit and as a diagnosis names it.
#[derive(Clone, Debug, Serialize)]
pub struct LostMotion {
    /// The model's gap, from contact to contact, rad.
    pub intended_rad: f64,
    /// Stretches of free travel that the creep shows, between two contacts, or up to or away from one, rad.
    pub free_ways_rad: Vec<f64>,
    /// The missing effects that a diagnosis names when it starts from the model without its gap or shaft.
    pub named: AddedByRendering,
    /// Effects that explain part of what that diagnosis cannot name, with the share of the gap in torque, %.
    pub partly: Vec<(String, f64)>,
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

impl Rendering {
    /// Whether the torque is close enough to the model's.
    #[must_use]
    pub fn torque_passes(&self) -> bool {
        self.torque_error_percent <= self.limits.torque_error_percent
    }

    /// Whether a knob that sticks is held within one step of the encoder.
    #[must_use]
    pub fn is_held_still(&self) -> bool {
        self.held_still.is_none_or(|held| held.encoder_steps < 1.0)
    }
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
