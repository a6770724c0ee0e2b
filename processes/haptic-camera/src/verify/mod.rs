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
use report::{AddedByRendering, Rendering, RenderingLimits, RenderingPage};
use rt_loop::plan::Plan;
use rt_loop::request::HandRequest;

use crate::outcome::{Outcome, show};
use crate::replay::ReplayOptions;
use crate::supervision::{Shown, SupervisedRun, archive_stem};

const LIMITS: RenderingLimits =
    RenderingLimits { difference_percent: 2.0, static_difference_percent: 5.0, torque_error_percent: 5.0 };

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
    let make =
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
    let (rendering, fit) = captures::verify(&model, options.pace.rate_hz, make)?;
    let results = &options.results;
    results.tell(model.axis, table::lines(&rendering), &rendering, || page(&model, &fit, &rendering))?;
    if let Some(path) = &results.report {
        show([format!("report   {}", path.display())]);
    }
    Ok(if rendering.passed { whole } else { Outcome::Failed })
}

/// The report page, which tells of a gap among its notes.
fn page(model: &Model, fit: &Fit, rendering: &Rendering) -> String {
    let gap = rendering.lost_motion.iter().flat_map(table::lost_motion_in_words);
    let notes = gap.chain(rendering.notes.iter().cloned()).collect();
    report::rendering_page(&RenderingPage { intended: model, fit, rendering: Rendering { notes, ..rendering.clone() } })
}
