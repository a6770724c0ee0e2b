//! The proof of a rendering: the rendered knob captured like any other, fitted, diagnosed and compared with its model.

mod captures;
mod compare;
mod page;
mod table;
mod two_bodies;

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

use anyhow::Context as _;
use archive::claim;
use clap::Parser as _;
use dynamics::{Model, knobs};
use identification::diagnosis::{Diagnosis, Verdict};
use report::CaptureFacts;
use serde::Serialize;

use crate::command_line::{ReplayOptions, RunOptions};
use crate::load;
use crate::outcome::{Outcome, say};
use crate::outputs::{Kind, to_output, write, write_json};
use crate::supervision::{Archived, Shown, SupervisedRun, archive_stem};
use compare::Verified;

/// Largest difference of a parameter that passes if its interval does not hold the intended value, %.
pub const LARGEST_DIFFERENCE_PERCENT: f64 = 2.0;
/// The same for what a knob bears at rest, %.
pub const LARGEST_STATIC_DIFFERENCE_PERCENT: f64 = 5.0;
/// Largest torque error that passes, as a share of the model's RMS torque, %.
pub const LARGEST_TORQUE_ERROR_PERCENT: f64 = 5.0;

/// How a rendered knob compares with the model that it was to be.
#[derive(Debug, Serialize)]
pub struct Verification {
    /// The model's name.
    pub model: String,
    /// Sample rate, Hz.
    pub rate_hz: f64,
    /// The captures made for it: two sweeps, a creep, and a hold if the knob sticks.
    pub captures: Vec<PathBuf>,
    /// The model's parameters, intended and rendered.
    pub parameters: Vec<Verified>,
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
    /// What the rendering adds that the model does not have; `None` with the reason in `notes` where that cannot be told.
    pub added: Option<Added>,
    /// What passes.
    pub limits: Limits,
    /// What a reader of the numbers should know.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether all of it is within what passes.
    pub passed: bool,
}

/// What `replay --verify --json` tells.
#[derive(Serialize)]
struct Told<'a> {
    #[serde(flatten)]
    verification: &'a Verification,
    /// The capture of the rendered knob that was fitted.
    capture: CaptureFacts,
}

/// What passes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Limits {
    /// Largest difference of a parameter whose interval does not hold the intended value, %.
    pub difference_percent: f64,
    /// The same for what a knob bears at rest, %.
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
    pub named: Added,
    /// Effects that explain part of what that diagnosis cannot name, with the share of the gap in torque, %.
    pub partly: Vec<(String, f64)>,
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
pub struct Added {
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

/// Whether a rendered knob is its model's: in its parameters, in its torque, and in how still it is held.
fn passes(parameters: &[Verified], torque_error_percent: f64, held_still: Option<&HeldStill>) -> bool {
    parameters.iter().all(|parameter| parameter.passed != Some(false))
        && torque_error_percent <= LARGEST_TORQUE_ERROR_PERCENT
        && held_still.is_none_or(|held| held.encoder_steps < 1.0)
}

impl Added {
    fn of(found: &Diagnosis) -> Self {
        Self {
            verdict: found.verdict,
            effects: found.effects.iter().map(ToString::to_string).collect(),
            heldout_rms_before: found.heldout_rms_before,
            heldout_rms_after: found.heldout_rms_after,
            noise_floor_rms: found.noise_floor_rms,
        }
    }
}

/// The model that is to be felt: the one asked for, or the nearest to it that the rig renders.
fn intended(options: &ReplayOptions) -> anyhow::Result<Model> {
    if !options.nearest {
        return Ok(knobs::named(&options.model)?);
    }
    let asked = ["rt-loop".to_owned(), format!("--render={}", options.model), "--nearest".to_owned()];
    let arguments = asked.into_iter().chain(options.run.loop_arguments());
    let plan = rt_loop::plan::Plan::new(&rt_loop::plan::Options::try_parse_from(arguments)?)?;
    Ok(plan.rendering.context("no model is rendered")?.model)
}

/// Verifies a rendering and tells the result; failed if the rendered knob is not the model's.
///
/// # Errors
/// What keeps a capture from being made, read or fitted.
pub fn run(options: &ReplayOptions, interrupted: &AtomicBool) -> anyhow::Result<Outcome> {
    let model = intended(options)?;
    let out = &options.run.out;
    let folder = claim::folder(out, &archive_stem(&options.model, "verify-"))
        .with_context(|| format!("no folder can be made in {}; choose another with --out", out.display()))?;
    // Nobody watches four captures in a row.
    let run_options = RunOptions { no_viewer: true, native_viewer: false, ..options.run.clone() };
    let mut remarks_told = false;
    let mut is_data_lost = false;
    let mut make = |name: &str, hand: &[String], duration_s: f64| -> anyhow::Result<PathBuf> {
        let archive = folder.join(format!("{name}.mcap"));
        let mut task = vec![format!("--render={}", options.model), format!("--duration-s={duration_s}")];
        if options.nearest {
            task.push("--nearest".to_owned());
        }
        if remarks_told {
            task.push("--without-remarks".to_owned());
        }
        remarks_told = true;
        let run = SupervisedRun {
            in_words: format!("rendering {} for the {name}, {duration_s} s", model.name),
            task: task.iter().chain(hand).cloned().collect(),
            options: &run_options,
            archive: archive.clone(),
            duration_s: Some(duration_s),
            until: None,
            shown: Shown::Rendering,
        };
        let end = run.take(interrupted)?.context("the control loop could not run")?;
        anyhow::ensure!(!end.interrupted, "stopped by the operator; the captures so far are in {}", folder.display());
        if let Some(fault) = end.fault_words() {
            anyhow::bail!("the {name} ended in a fault: {fault}");
        }
        let archive = end.left_archive(&archive).with_context(|| format!("the {name} left no archive"))?;
        let outcome = end.settle(&Archived::read(&archive)?);
        anyhow::ensure!(outcome != Outcome::Failed, "the {name} did not come to its end");
        is_data_lost |= outcome == Outcome::DataLost;
        Ok(archive)
    };
    let captured = captures::verify(&model, options.run.rate_hz, &mut make)?;
    let verification = &captured.verification;
    if !to_output(options.json.as_deref()) {
        table::lines(verification).iter().for_each(say);
    }
    write_json(options.json.as_deref(), &Told { verification, capture: load::facts(&captured.train) })?;
    if let Some(path) = &options.report {
        write(path, Kind::Page, &page::page(&model, &captured))?;
        if !to_output(options.json.as_deref()) {
            say(format!("report   {}", path.display()));
        }
    }
    Ok(match (verification.passed, is_data_lost) {
        (true, false) => Outcome::Done,
        (true, true) => Outcome::DataLost,
        (false, _) => Outcome::Failed,
    })
}
