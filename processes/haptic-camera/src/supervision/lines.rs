//! The state of a run in one plain line.

use dynamics::Axis;
use shared_types::Sample;

use super::loop_link::LoopLink;
use super::panel::losses;
use crate::capture::share_words;
use crate::until_ci::{Knowledge, Share};

/// How far run and fit are, how late the loop was and what was lost.
pub(super) fn fit_line(link: &LoopLink, until: Option<Share>) -> String {
    let axis = link.rig.axis;
    let known = link.fit().map_or_else(String::new, |fit| {
        let residual = if fit.residual_rms_mnm.is_finite() {
            axis.words(&format!(", residual {:.*} mNm", 2 + finer(axis), fit.residual_rms_mnm)).into_owned()
        } else {
            String::new()
        };
        format!("{residual}, {}", known_words(&Knowledge::from(fit), until))
    });
    format!("{}{known}", time_line(link))
}

/// How far the run is, how late the loop was and what was lost.
pub(super) fn time_line(link: &LoopLink) -> String {
    format!("{:5.1} s, {}", link.elapsed_s(), losses(link))
}

/// How many parameters are known well enough, or the one that an end of the sweep waits for most.
fn known_words(knowledge: &Knowledge, until: Option<Share>) -> String {
    match (until, knowledge.open().first()) {
        (Some(share), None) => format!("all within {share}"),
        (Some(_), Some(least_known)) => share_words(least_known),
        (None, _) => {
            let in_model = knowledge.parameters.iter().filter(|known| known.is_in_model);
            format!("{} of {} known", in_model.clone().filter(|known| known.is_settled()).count(), in_model.count())
        }
    }
}

/// Digits that a load in N takes more than one in mNm.
fn finer(axis: Axis) -> usize {
    if axis.is_rotary() { 0 } else { 2 }
}

/// What a hand does to a rendered model, and what it feels.
#[allow(clippy::cast_precision_loss, reason = "for display")]
pub(super) fn rendering_line(link: &LoopLink) -> String {
    let status = &link.status;
    let contact = if status.flags & Sample::STUCK == 0 { "sliding" } else { "stuck" };
    let model = link.models.last().map_or("", |model| model.name.as_str());
    let axis = link.rig.axis;
    let felt =
        format!("{:+.3} rad, {contact}, hand {:+.*} mNm", status.angle_rad, 1 + finer(axis), link.hand_torque_mnm());
    format!(
        "{:5.1} s, {}, late by {:.3} ms at most, {} missed, {model}",
        link.elapsed_s(),
        axis.words(&felt),
        status.max_lateness_ns as f64 / 1e6,
        status.missed_ticks
    )
}
