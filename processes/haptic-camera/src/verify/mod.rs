//! The proof of a rendering: the rendered knob captured like any other, fitted, diagnosed and compared with its model.

mod captures;
mod compare;
mod table;
mod two_bodies;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use archive::claim;
use dynamics::Model;
use identification::Fit;
use identification::diagnosis::Diagnosis;
use report::{AddedByRendering, CaptureFacts, HeldStill, RenderedParameter, RenderingPage};
use rt_loop::plan::Plan;
use rt_loop::request::HandRequest;
use serde::Serialize;

use crate::outcome::{Outcome, show};
use crate::replay::ReplayOptions;
use crate::supervision::{Shown, SupervisedRun, archive_stem};

/// Largest difference of a parameter that passes if its interval does not hold the intended value, %.
pub const LARGEST_DIFFERENCE_PERCENT: f64 = 2.0;
/// The same for static friction, %.
pub const LARGEST_STATIC_DIFFERENCE_PERCENT: f64 = 5.0;
/// Largest torque error that passes, as a share of the model's RMS torque, %.
pub const LARGEST_TORQUE_ERROR_PERCENT: f64 = 5.0;

/// How a rendered knob compares with its model, as `replay --verify --json` writes it.
#[derive(Debug, Serialize)]
pub struct Verification {
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
    pub limits: Limits,
    /// What a reader of the numbers should know.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether all of it is within what passes: parameters, torque, and how still the knob is held.
    pub passed: bool,
    /// The capture of the rendered knob that was fitted.
    pub capture: CaptureFacts,
}

/// What passes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Limits {
    /// Largest difference of a parameter whose interval does not hold the intended value, %.
    pub difference_percent: f64,
    /// The same for static friction, %.
    pub static_difference_percent: f64,
    /// Largest torque error, %.
    pub torque_error_percent: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            difference_percent: LARGEST_DIFFERENCE_PERCENT,
            static_difference_percent: LARGEST_STATIC_DIFFERENCE_PERCENT,
            torque_error_percent: LARGEST_TORQUE_ERROR_PERCENT,
        }
    }
}

/// The gap of a rendered knob, as it shows without a fit and as a diagnosis names it.
#[derive(Clone, Debug, Serialize)]
pub struct LostMotion {
    /// The model's gap, from contact to contact, rad.
    pub intended_rad: f64,
    /// Free ways that the creep shows, from contact to contact or from or to one, rad.
    pub free_ways_rad: Vec<f64>,
    /// What a diagnosis calls missing that starts from the model without its gap or shaft.
    pub named: AddedByRendering,
    /// Effects that explain part of what that diagnosis cannot name, with the share of the gap in torque, %.
    pub partly: Vec<(String, f64)>,
}

/// What the captures of a rendered knob tell of it beside its model.
struct Compared {
    parameters: Vec<RenderedParameter>,
    /// RMS of rendered minus intended torque, and of the intended torque, mNm.
    torque_rms_mnm: [f64; 2],
    lost_motion: Option<LostMotion>,
    added: Option<AddedByRendering>,
    notes: Vec<String>,
}

/// What a diagnosis that starts from the intended model found.
fn added(found: &Diagnosis) -> AddedByRendering {
    AddedByRendering {
        verdict: found.verdict,
        effects: found.effects.iter().map(ToString::to_string).collect(),
        heldout_rms_before: found.heldout_rms_before,
        heldout_rms_after: found.heldout_rms_after,
        noise_floor_rms: found.noise_floor_rms,
    }
}

/// Verifies a rendering and tells the result; failed if the rendered knob is not the model's.
pub fn run(options: &ReplayOptions, interrupted: &AtomicBool) -> anyhow::Result<Outcome> {
    let mut asked = options.request();
    // The model that is to be felt: the one asked for, or the nearest to it that the rig renders.
    let model = Plan::new(&asked)?.rendering.context("no model is rendered")?.model;
    let out = &options.run.out;
    let folder = claim::folder(out, &archive_stem(asked.knob_name(), "verify-"))
        .with_context(|| format!("cannot create a folder in {}; choose another with --out", out.display()))?;
    let mut whole = Outcome::Done;
    let mut make =
        |name: &str, hand: HandRequest, amplitude_rad: Option<f64>, duration_s: f64| -> anyhow::Result<PathBuf> {
            asked.duration_s = duration_s;
            (asked.rig.simulated.hand, asked.amplitude) = (Some(hand), amplitude_rad);
            let run = SupervisedRun {
                in_words: format!("rendering {} for the {name}, {duration_s} s", model.name),
                request: asked.clone(),
                offline: options.run.offline,
                // Nobody watches four captures in a row.
                viewer: None,
                archive: folder.join(format!("{name}.mcap")),
                until: None,
                shown: Shown::Rendering,
            };
            let (archive, outcome) = run.complete(interrupted)?;
            whole = whole.worse(outcome);
            // Once is enough.
            asked.rendering.iter_mut().for_each(|rendering| rendering.without_remarks = true);
            Ok(archive)
        };
    let (verification, fit) = captures::verify(&model, options.pace.rate_hz, &mut make)?;
    let results = &options.results;
    results.tell(model.axis, table::lines(&verification), &verification, || page(&model, &fit, &verification))?;
    if let Some(path) = &results.report {
        show([format!("report   {}", path.display())]);
    }
    Ok(if verification.passed { whole } else { Outcome::Failed })
}

/// The report page.
fn page(model: &Model, fit: &Fit, verification: &Verification) -> String {
    let file_name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let gap = verification.lost_motion.iter().flat_map(table::lost_motion_in_words);
    report::rendering_page(&RenderingPage {
        intended: model,
        fit,
        capture: CaptureFacts { title: model.name.clone(), ..verification.capture.clone() },
        sources: verification.captures.iter().map(file_name).collect(),
        rate_hz: verification.rate_hz,
        parameters: verification.parameters.clone(),
        largest_difference_percent: verification.limits.difference_percent,
        largest_static_difference_percent: verification.limits.static_difference_percent,
        torque_error_rms_mnm: verification.torque_error_rms_mnm,
        torque_rms_mnm: verification.torque_rms_mnm,
        torque_error_percent: verification.torque_error_percent,
        largest_torque_error_percent: verification.limits.torque_error_percent,
        held_still: verification.held_still,
        added: verification.added.clone(),
        notes: gap.chain(verification.notes.iter().cloned()).collect(),
        passed: verification.passed,
    })
}
