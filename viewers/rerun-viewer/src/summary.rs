//! The text next to the plots: the run, its loop and its parameters.

use dynamics::ParameterKind;
use identification::live::USUAL_SHARE;
use shared_types::{Estimate, Fault, LoopState, LoopStatus, RunDescription, realtime};

use crate::model_torque::finite_value;
use crate::numbers::{alarmed, grouped, value_and_interval};
use crate::rendered::RenderedModel;
use crate::run::Run;

/// The run and its loop as Markdown.
pub fn markdown(run: &Run) -> String {
    let control_loop = run.status.as_ref().map(control_loop).unwrap_or_default();
    head(run) + &control_loop + &run.rendered.as_ref().map(RenderedModel::markdown).unwrap_or_default()
}

fn head(run: &Run) -> String {
    let Some(RunDescription { knob, apparatus, rate_hz, .. }) = &run.description else {
        return "# Waiting for a run\n\n".to_owned();
    };
    let (knob, rate_khz) = (knob_title(knob), rate_hz / 1_000.0);
    let planned = run.planned_s().map_or_else(String::new, |planned_s| format!(" of {planned_s:.1} s"));
    let (state, time_s) = (state(run), run.time_s());
    format!("# {knob}\n\non **{apparatus}**, {rate_khz} kHz\n\n### {state} \u{2014} {time_s:.1} s{planned}\n\n")
}

/// The knob as a heading; the paper's are given by number.
pub fn knob_title(knob: &str) -> String {
    if knob.parse::<u32>().is_ok() { format!("Knob {knob}") } else { knob.to_owned() }
}

/// The state of the run in words.
pub fn state(run: &Run) -> String {
    let Some(status) = run.status else { return "no control loop".to_owned() };
    if run.source_gone {
        return "SOURCE GONE: the control loop died".to_owned();
    }
    match (LoopState::from_code(status.state), Fault::from_code(status.fault)) {
        (Some(LoopState::Fault), Some(fault)) => format!("FAULT: {fault}"),
        (Some(LoopState::Fault), None) => "FAULT".to_owned(),
        (_, _) if status.finished != 0 => "finished".to_owned(),
        (Some(state), _) => format!("{state:?}").to_lowercase(),
        (None, _) => format!("state {}", status.state),
    }
}

fn control_loop(status: &LoopStatus) -> String {
    let max_lateness_us = status.max_lateness_ns as f64 / 1_000.0;
    format!(
        "| control loop | |\n|---|---:|\n| samples | {} |\n| missed ticks | {} |\n| dropped samples | {} |\n\
         | largest lateness | {max_lateness_us:.1} µs |\n| real-time permission | {} |\n\n",
        grouped(status.published_samples),
        alarmed(status.missed_ticks),
        alarmed(status.dropped_samples),
        if status.realtime & realtime::FULL == realtime::FULL { "granted" } else { "not granted in full" },
    )
}

/// The parameters as Markdown: each with its value, its 95 % interval and the plain word.
pub fn parameters(run: &Run) -> String {
    let Some(fit) = &run.fit else { return "Waiting for the fit".to_owned() };
    let row = |(kind, estimate): (&ParameterKind, Estimate)| {
        let word = if estimate.is_settled() { "enough" } else { "**not yet**" };
        let unit = finite_value(&estimate).map_or_else(String::new, |_| format!(" {}", kind.unit));
        format!("| {word} | {} | {}{unit} |\n", kind.name.replace('_', " "), value_and_interval(&estimate))
    };
    let rows: String = run.parameters().map(row).collect();
    let (all, enough) = (run.parameters().count(), run.parameters().filter(|(_, one)| one.is_settled()).count());
    let residual = if fit.residual_rms_mnm.is_finite() {
        let samples = grouped(fit.samples);
        format!("\nresidual **{:.3} mNm** RMS over {samples} samples\n\n", fit.residual_rms_mnm)
    } else {
        String::new()
    };
    format!(
        "## {enough} of {all} enough\n\n| | parameter | value ± 95 % |\n|---|---|---|\n{rows}{residual}\n\
         enough: half the 95 % interval is as small a share of the value as was asked for, else {:.0} %, or the torque \
         sensor cannot show the parameter\n",
        100.0 * USUAL_SHARE
    )
}

#[cfg(test)]
mod tests {
    use shared_types::{Convergence, FitUpdate, Verdict};

    use super::*;
    use crate::model_torque::tests::estimated;

    #[test]
    fn the_plain_word_stands_beside_each_parameter_that_the_model_has() {
        let mut fit = FitUpdate {
            coulomb_positive: estimated(2.3, 0.012, Convergence::Converged),
            inertia: estimated(0.035, 9.0, Convergence::Open),
            ..FitUpdate::default()
        };
        fit.detent_phase.verdict = Verdict::Absent.code();
        let text = parameters(&Run { fit: Some(fit), ..Run::default() });
        assert!(text.contains("## 1 of 7 enough"), "{text}");
        assert!(text.contains("| enough | coulomb positive | 2.300 ± 0.012 mNm |"), "{text}");
        assert!(text.contains("| **not yet** | inertia | 0.0 ± 9.0 mNm s²/rad |"), "{text}");
        assert!(!text.contains("detent phase"), "{text}");
    }

    #[test]
    fn a_fault_says_its_cause_and_a_control_loop_that_died_is_not_shown_as_running() {
        let of = |state: LoopState, source_gone| {
            let status = LoopStatus { state: state.code(), fault: Fault::Speed.code(), ..LoopStatus::default() };
            super::state(&Run { status: Some(status), source_gone, ..Run::default() })
        };
        assert_eq!(of(LoopState::Fault, false), "FAULT: the speed exceeded the rig's limit");
        assert_eq!(of(LoopState::Running, false), "running");
        assert!(of(LoopState::Running, true).contains("GONE"));
    }

    #[test]
    fn a_knob_of_the_paper_is_called_by_its_number() {
        assert_eq!(["3", "my-knob.toml"].map(knob_title), ["Knob 3", "my-knob.toml"]);
    }
}
