//! The diagnosis in words, beside the plots.

use std::fmt::Write as _;

use identification::diagnosis::Rival;

use super::{Input, contenders};
use crate::numbers::three_figures;

pub fn markdown(input: &Input) -> String {
    let found = &input.diagnosis;
    let mut text = format!("# {}\n", found.summary);
    for capture in &input.captures {
        let _ = writeln!(text, "\n{}: {}", capture.role, capture.source);
    }
    if !found.steps.is_empty() {
        text.push_str("\n| added | before, mNm | after, mNm | null effect, mNm |\n|---|---|---|---|\n");
    }
    for step in &found.steps {
        let [before, after, null] =
            [step.heldout_rms_before, step.heldout_rms_after, step.placebo_rms].map(three_figures);
        let _ = writeln!(text, "| {} | {before} | {after} | {null} |", step.effect);
    }
    let _ = writeln!(
        text,
        "\nThe last model leaves {} mNm of the held-out capture; noise alone leaves {} mNm.",
        three_figures(found.heldout_rms_after),
        three_figures(found.noise_floor_rms)
    );
    for step in &found.steps {
        let _ =
            writeln!(text, "\n## {}\n\n| parameter | value | 95 % interval | unit |\n|---|---|---|---|", step.effect);
        for (name, value) in &step.parameters {
            let ends = value.ci95.map(|ends| ends.map(three_figures));
            let interval = ends.map_or("–".to_owned(), |[low, high]| format!("{low} … {high}"));
            let _ = writeln!(
                text,
                "| {name} | {} | {interval} | {} |",
                three_figures(value.value),
                dynamics::printed_unit(value.unit)
            );
        }
        if !step.ties.is_empty() {
            let _ = writeln!(text, "\n**A tie** with {}.", step.ties.join(" and "));
        }
        text.push_str("\n| rival | left, mNm | evidence, nats | |\n|---|---|---|---|\n");
        for Rival { effect, heldout_rms_after, evidence, disqualified, .. } in contenders(step) {
            let [rms, evidence] = [heldout_rms_after, evidence].map(three_figures);
            let _ = writeln!(text, "| {effect} | {rms} | {evidence} | {} |", disqualified.unwrap_or_default());
        }
    }
    if let Some([before, after]) = found.forward_angle_rms_rad {
        let _ = writeln!(text, "\nMotion predicted from the measured torque: {before:.2e} rad, then {after:.2e} rad.");
    }
    if let Some(forward) = &found.forward_from_command {
        let errors: Vec<String> = forward.angle_rms_rad.iter().map(|error| format!("{error:.2e}")).collect();
        let _ = writeln!(text, "\nMotion predicted from the command, effect by effect: {} rad.", errors.join(", "));
    }
    if let Some(next) = &found.next_experiment {
        let _ = writeln!(text, "\n**Next:** {}.", next.reason);
    }
    for note in &found.notes {
        let _ = writeln!(text, "\n- {note}");
    }
    text
}
