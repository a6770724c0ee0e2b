//! The state of a run in one plain line.

use shared_types::{Sample, Verdict};

use super::loop_link::LoopLink;
use super::panel::{losses, standing_words};
use crate::until_ci::{Knowledge, Standing, Yardstick};

/// How far run and fit are, how late the loop was and what was lost.
pub(super) fn fit_line(link: &LoopLink, yardstick: Option<&Yardstick>) -> String {
    let known = link.fit().map_or_else(String::new, |fit| {
        let enough = fit.estimates().iter().filter(|(_, e)| e.verdict == Verdict::Enough.code()).count();
        let told = fit.estimates().iter().filter(|(_, e)| e.verdict != Verdict::Absent.code()).count();
        let residual = if fit.residual_rms_mnm.is_finite() {
            format!(", residual {:.2} mNm", fit.residual_rms_mnm)
        } else {
            String::new()
        };
        match yardstick {
            None => format!("{residual}, {enough} of {told} known"),
            Some(yardstick) => format!("{residual}, {}", widest(&Knowledge::from(fit), yardstick)),
        }
    });
    format!("{}{known}", time_line(link))
}

/// How far the run is, how late the loop was and what was lost.
pub(super) fn time_line(link: &LoopLink) -> String {
    format!("{:5.1} s, {}", link.elapsed_s(), losses(link))
}

/// The parameter that an end of the sweep waits for most.
fn widest(knowledge: &Knowledge, yardstick: &Yardstick) -> String {
    let wanting = knowledge.parameters.iter().filter_map(|known| match yardstick.standing(known, knowledge) {
        Standing::Wanting(share) => Some((known.name, share)),
        _ => None,
    });
    let widest = wanting.max_by(|one, other| {
        let width = |share: Option<f64>| share.unwrap_or(f64::INFINITY);
        width(one.1).total_cmp(&width(other.1))
    });
    match widest {
        None => format!("all within ± {:.2} %", 100.0 * yardstick.share),
        Some((name, share)) => format!("{name} {}", standing_words(Standing::Wanting(share))),
    }
}

/// What a hand does to a rendered model, and what it feels.
#[allow(clippy::cast_precision_loss, reason = "for display")]
pub(super) fn rendering_line(link: &LoopLink) -> String {
    let status = link.status();
    let contact = if status.flags & Sample::STUCK == 0 { "sliding" } else { "stuck" };
    let model = link.models().last().map_or("", |model| model.name.as_str());
    format!(
        "{:5.1} s, {:+.3} rad, {contact}, hand {:+.1} mNm, late by {:.3} ms at most, {} missed, {model}",
        link.elapsed_s(),
        status.angle_rad,
        link.hand_torque_mnm(),
        status.max_lateness_ns as f64 / 1e6,
        status.missed_ticks
    )
}
