//! A rendering in words, for an 80-column terminal.

use identification::diagnosis::Verdict;
use report::{AddedByRendering, HeldStill, LostMotion, RenderedParameter, Rendering};

use crate::terminal;

pub fn lines(rendering: &Rendering) -> Vec<String> {
    let header = ["parameter", "intended", "rendered", "95 % interval", "off", ""];
    let table = terminal::table(header, [1, 2, 4], rendering.parameters.iter().map(row));
    let Rendering { torque_error_rms_mnm, torque_rms_mnm, torque_error_percent, .. } = rendering;
    let mut lines = vec![table.to_string()];
    lines.push(format!(
        "torque   rendered minus intended {torque_error_rms_mnm:.*} of {torque_rms_mnm:.*} mNm RMS, \
         {torque_error_percent:.2} % (at most {} %)",
        decimals(1e3 * torque_error_rms_mnm).max(3),
        decimals(*torque_rms_mnm).max(2),
        rendering.limits.torque_error_percent,
    ));
    lines.extend(rendering.lost_motion.iter().flat_map(lost_motion_in_words));
    lines.extend(rendering.held_still.map(|HeldStill { torque_mnm, duration_s, encoder_steps }| {
        let decimals = decimals(torque_mnm).max(1);
        format!(
            "held     under {torque_mnm:.decimals$} mNm for {duration_s:.1} s: {encoder_steps:.1} steps of the encoder"
        )
    }));
    lines.extend(rendering.added.iter().map(|added| format!("added    {}", in_words(added))));
    lines.extend(rendering.notes.iter().map(|note| format!("- {note}")));
    let verdict = if rendering.passed { "the rendered knob is the model's" } else { "the rendered knob differs" };
    lines.push(format!("verdict  {verdict}"));
    lines
}

fn row(parameter: &RenderedParameter) -> [String; 6] {
    let digits = decimals(parameter.intended);
    let number = |value: f64| format!("{value:.digits$}");
    [
        parameter.name.to_owned(),
        number(parameter.intended),
        parameter.rendered.map_or_else(|| "-".to_owned(), number),
        terminal::interval(parameter.ci95, digits),
        parameter.difference_percent.map_or_else(String::new, |percent| format!("{percent:+.2} %")),
        match parameter.passed {
            Some(true) => String::new(),
            Some(false) => "✗".to_owned(),
            None => "-".to_owned(),
        },
    ]
}

/// Four decimals, or as many as give a small number four digits.
fn decimals(value: f64) -> usize {
    terminal::decimals(value, 4.0, [4.0, 12.0])
}

pub(super) fn lost_motion_in_words(lost: &LostMotion) -> [String; 2] {
    let mut ways = lost.free_ways_rad.clone();
    ways.sort_by(f64::total_cmp);
    let seen = match (ways.last(), ways.get(ways.len() / 2)) {
        (Some(longest), Some(middle)) => {
            format!("{} free travels in the creep, {middle:.4} rad median, {longest:.4} at most", ways.len())
        }
        _ => "no free travel in the creep".to_owned(),
    };
    let partly: Vec<String> =
        lost.partly.iter().map(|(effect, percent)| format!("{effect} {percent:.0} % of it")).collect();
    let partly = if partly.is_empty() { String::new() } else { format!("; {}", partly.join(", ")) };
    [
        format!("gap      {:.4} rad intended; {seen}", lost.intended_rad),
        format!("missing  without the gap, by a diagnosis: {}{partly}", in_words(&lost.named)),
    ]
}

fn in_words(added: &AddedByRendering) -> String {
    let AddedByRendering { heldout_rms_before, heldout_rms_after, noise_floor_rms, .. } = added;
    match added.verdict {
        Verdict::None => {
            format!("nothing: residual {heldout_rms_before:.3} mNm on another motion, noise {noise_floor_rms:.3}")
        }
        Verdict::Effects => format!(
            "{}: residual {heldout_rms_before:.3} to {heldout_rms_after:.3} mNm on another motion, noise \
             {noise_floor_rms:.3}",
            added.effects.join(", ")
        ),
        Verdict::OutsideLibrary => format!(
            "an unknown effect: residual {heldout_rms_after:.3} mNm on another motion, noise {noise_floor_rms:.3}"
        ),
    }
}
