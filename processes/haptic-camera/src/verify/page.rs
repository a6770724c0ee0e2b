//! The report page of a verification.

use dynamics::Model;
use report::{AddedByRendering, CaptureFacts, RenderedParameter, RenderingPage};

use super::captures::Captured;
use super::compare::Verified;
use super::table::lost_motion_in_words;
use super::{Added, HeldStill, Verification};

/// The page as HTML.
pub(super) fn page(model: &Model, captured: &Captured) -> String {
    let Verification {
        model: _,
        rate_hz,
        captures,
        parameters,
        torque_error_rms_mnm,
        torque_rms_mnm,
        torque_error_percent,
        lost_motion,
        held_still,
        added,
        limits,
        notes,
        passed,
    } = &captured.verification;
    let file_name = |path: &std::path::PathBuf| {
        path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    };
    report::rendering_page(&RenderingPage {
        intended: model,
        fit: &captured.fit,
        capture: CaptureFacts { title: model.name.clone(), ..analysis::facts(&captured.train) },
        sources: captures.iter().map(file_name).collect(),
        rate_hz: *rate_hz,
        parameters: parameters.iter().map(shown).collect(),
        largest_difference_percent: limits.difference_percent,
        largest_static_difference_percent: limits.static_difference_percent,
        torque_error_rms_mnm: *torque_error_rms_mnm,
        torque_rms_mnm: *torque_rms_mnm,
        torque_error_percent: *torque_error_percent,
        largest_torque_error_percent: limits.torque_error_percent,
        held_still: held_still.map(|HeldStill { torque_mnm, duration_s, encoder_steps }| report::HeldStill {
            torque_mnm,
            duration_s,
            encoder_steps,
        }),
        added: added.as_ref().map(|added| {
            let Added { verdict, effects, heldout_rms_before, heldout_rms_after, noise_floor_rms } = added;
            AddedByRendering {
                verdict: *verdict,
                effects: effects.clone(),
                heldout_rms_before: *heldout_rms_before,
                heldout_rms_after: *heldout_rms_after,
                noise_floor_rms: *noise_floor_rms,
            }
        }),
        notes: lost_motion.iter().flat_map(lost_motion_in_words).chain(notes.iter().cloned()).collect(),
        passed: *passed,
    })
}

fn shown(parameter: &Verified) -> RenderedParameter {
    let Verified { name, unit, intended, rendered, ci95, difference_percent, passed, reason } = parameter;
    RenderedParameter {
        name,
        unit,
        intended: *intended,
        rendered: *rendered,
        ci95: *ci95,
        difference_percent: *difference_percent,
        passed: *passed,
        reason: reason.clone(),
    }
}
