//! The text next to the plots: the run, its loop and its parameters.

use std::fmt::Write as _;

use identification::live::USUAL_SHARE;
use shared_types::{Estimate, Fault, FitUpdate, LoopState, LoopStatus, RunDescription, realtime};

use crate::consumers::Consumers;
use crate::entities::{PARAMETERS, SIGNALS};
use crate::knob_track::Motion;
use crate::model_torque::finite_value;
use crate::rendered::RenderedModel;
use crate::source::Reading;

/// What the text is made of.
#[derive(Clone, Copy, Debug)]
pub struct Facts<'a> {
    /// What the run is.
    pub description: Option<&'a RunDescription>,
    /// The control loop's word about itself.
    pub status: Option<&'a LoopStatus>,
    /// Whether the control loop died before its run had ended.
    pub source_gone: bool,
    /// The model fitted so far.
    pub fit: Option<&'a FitUpdate>,
    /// The model that is rendered.
    pub rendered: Option<&'a RenderedModel>,
    /// Smallest and largest value of each signal over the last seconds.
    pub ranges: [(&'static str, Option<(f64, f64)>); SIGNALS.len()],
    /// The other processes.
    pub consumers: &'a Consumers,
    /// Time in the run, s.
    pub time_s: Option<f64>,
    /// Frames that the screen was too slow for.
    pub frames_dropped: u64,
    /// The newest reading.
    pub newest: Option<Reading>,
    /// Whether the knob sticks.
    pub motion: Option<Motion>,
    /// CLOCK_MONOTONIC now, ns.
    pub now_ns: u64,
}

/// The run and its loop as Markdown.
pub fn markdown(facts: &Facts<'_>) -> String {
    // Writing to a String does not fail.
    let mut text = String::new();
    head(&mut text, facts);
    if let Some(status) = facts.status {
        control_loop(&mut text, status);
    }
    if let Some(rendered) = facts.rendered {
        rendered.markdown(&mut text);
    }
    ranges(&mut text, "last 10 s", facts.ranges);
    text
}

fn head(text: &mut String, facts: &Facts<'_>) {
    let Some(description) = facts.description else {
        let _ = writeln!(text, "# Waiting for a run\n");
        return;
    };
    let RunDescription { knob, apparatus, rate_hz, .. } = description;
    let knob = knob_title(knob);
    let _ = writeln!(text, "# {knob}\n\non **{apparatus}**, {} kHz\n", rate_hz / 1_000.0);
    let planned = planned_s(description).map_or_else(String::new, |planned_s| format!(" of {planned_s:.1} s"));
    let _ = writeln!(
        text,
        "### {} \u{2014} {:.1} s{planned}\n",
        state(facts.status, facts.source_gone),
        facts.time_s.unwrap_or(0.0)
    );
}

/// Length of a run, s; `None` where the operator ends it.
pub fn planned_s(description: &RunDescription) -> Option<f64> {
    #[allow(clippy::cast_precision_loss, reason = "shown with one digit")]
    let planned_s = description.planned_ticks as f64 / description.rate_hz;
    (description.planned_ticks > 0).then_some(planned_s)
}

/// The knob as a heading; the paper's are given by number.
pub fn knob_title(knob: &str) -> String {
    if knob.parse::<u32>().is_ok() { format!("Knob {knob}") } else { knob.to_owned() }
}

/// The state of the run in words.
pub fn state(status: Option<&LoopStatus>, source_gone: bool) -> String {
    let Some(status) = status else {
        return "no control loop".to_owned();
    };
    if source_gone {
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

fn control_loop(text: &mut String, status: &LoopStatus) {
    let permissions =
        if status.realtime & realtime::FULL == realtime::FULL { "granted" } else { "not granted in full" };
    #[allow(clippy::cast_precision_loss, reason = "shown with one digit")]
    let max_lateness_us = status.max_lateness_ns as f64 / 1_000.0;
    let rows = [
        ("samples", grouped(status.published_samples)),
        ("missed ticks", alarmed(status.missed_ticks)),
        ("dropped samples", alarmed(status.dropped_samples)),
        ("largest lateness", format!("{max_lateness_us:.1} µs")),
        ("real-time permission", permissions.to_owned()),
    ];
    let _ = writeln!(text, "| control loop | |\n|---|---:|");
    for (name, value) in rows {
        let _ = writeln!(text, "| {name} | {value} |");
    }
    text.push('\n');
}

/// The parameters as Markdown: each with its value, its 95 % interval and the plain word.
pub fn parameters(facts: &Facts<'_>) -> String {
    let Some(fit) = facts.fit else { return "Waiting for the fit".to_owned() };
    let mut text = "| | parameter | value ± 95 % |\n|---|---|---|\n".to_owned();
    let (mut enough, mut all) = (0, 0);
    for ((name, estimate), (_, unit)) in fit.estimates().into_iter().zip(PARAMETERS) {
        if estimate.is_in_model() {
            all += 1;
            enough += u32::from(estimate.is_settled());
            let word = if estimate.is_settled() { "enough" } else { "**not yet**" };
            let value = match finite_value(&estimate) {
                Some(_) => format!("{} {unit}", value_and_interval(&estimate)),
                None => value_and_interval(&estimate),
            };
            let _ = writeln!(text, "| {word} | {} | {value} |", name.replace('_', " "));
        }
    }
    if fit.residual_rms_mnm.is_finite() {
        let samples = grouped(fit.samples);
        let _ = writeln!(text, "\nresidual **{:.3} mNm** RMS over {samples} samples\n", fit.residual_rms_mnm);
    }
    format!(
        "## {enough} of {all} enough

{text}
enough: half the 95 % interval is as small a share of the value as was asked \
         for, else {:.0} %, or the torque sensor cannot show the parameter
",
        100.0 * USUAL_SHARE
    )
}

/// The smallest and the largest value of each signal as a table; nothing where there is no value.
pub fn ranges(text: &mut String, of: &str, ranges: impl IntoIterator<Item = (&'static str, Option<(f64, f64)>)>) {
    let mut ranges = ranges.into_iter().filter_map(|(signal, range)| Some((signal, range?))).peekable();
    if ranges.peek().is_none() {
        return;
    }
    let _ = writeln!(text, "| {of} | from | to |\n|---|---:|---:|");
    for (signal, (low, high)) in ranges {
        let _ = writeln!(text, "| {signal} | {} | {} |", three_digits(low), three_digits(high));
    }
    text.push('\n');
}

/// `2.301 ± 0.012`, with as many digits as the interval deserves; a dash until it is identified.
pub fn value_and_interval(estimate: &Estimate) -> String {
    let Some(value) = finite_value(estimate) else {
        return "\u{2013}".to_owned();
    };
    with_half_width(value, (estimate.ci95_high - estimate.ci95_low) / 2.0)
}

/// Power of ten below which a number is written with it.
const SMALL_POWER: i32 = -3;

/// `2.301 ± 0.012`, with two digits of the half width; `(3.99 ± 0.03)e−6` of what is small.
pub fn with_half_width(value: f64, half_width: f64) -> String {
    #[allow(clippy::cast_possible_truncation, reason = "a power of ten of a number")]
    let power = value.abs().max(half_width).log10().floor() as i32;
    if (-30..SMALL_POWER).contains(&power) {
        let scale = 10_f64.powi(power);
        return format!("({})e\u{2212}{}", with_half_width(value / scale, half_width / scale), -power);
    }
    let sign = |number: String| number.replace('-', "\u{2212}");
    if !half_width.is_finite() || half_width <= 0.0 {
        return sign(format!("{value:.4}"));
    }
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..=8")]
    let decimals = (1.0 - half_width.log10().floor()).clamp(0.0, 8.0) as usize;
    sign(format!("{value:.decimals$} ± {half_width:.decimals$}"))
}

/// A number with about three digits that count.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to 0..=3")]
pub fn three_digits(value: f64) -> String {
    let decimals = (2.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 3.0) as usize;
    let digits = format!("{:.decimals$}", value.abs());
    let is_zero = digits.bytes().all(|digit| matches!(digit, b'0' | b'.'));
    if value < 0.0 && !is_zero { format!("\u{2212}{digits}") } else { digits }
}

/// A count that should be zero.
pub fn alarmed(count: u64) -> String {
    if count == 0 { "0".to_owned() } else { format!("**{}**", grouped(count)) }
}

/// A count with its thousands apart.
pub fn grouped(count: u64) -> String {
    let digits = count.to_string();
    let mut text = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
impl<'a> Facts<'a> {
    /// Before anything is known.
    pub fn nothing(consumers: &'a Consumers) -> Self {
        Self {
            description: None,
            status: None,
            source_gone: false,
            fit: None,
            rendered: None,
            ranges: SIGNALS.map(|signal| (signal, None)),
            consumers,
            time_s: None,
            frames_dropped: 0,
            newest: None,
            motion: None,
            now_ns: 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use shared_types::{Convergence, Verdict};

    use super::*;

    fn estimated(value: f64, half_width: f64, convergence: Convergence) -> Estimate {
        let (ci95_low, ci95_high) = (value - half_width, value + half_width);
        let (verdict, convergence) = (Verdict::Estimated.code(), convergence.code());
        Estimate { value, ci95_low, ci95_high, verdict, convergence }
    }

    fn enough(value: f64, half_width: f64) -> Estimate {
        estimated(value, half_width, Convergence::Converged)
    }

    #[test]
    fn a_value_has_two_digits_of_its_interval() {
        assert_eq!(value_and_interval(&enough(2.301_234, 0.012_4)), "2.301 ± 0.012");
        assert_eq!(value_and_interval(&enough(-0.035, 0.000_21)), "\u{2212}0.03500 ± 0.00021");
    }

    #[test]
    fn what_is_not_identified_has_no_number() {
        assert_eq!(value_and_interval(&Estimate { value: 5.0, ..Estimate::default() }), "\u{2013}");
        assert_eq!(value_and_interval(&enough(f64::NAN, 1.0)), "\u{2013}");
    }

    #[test]
    fn the_plain_word_stands_beside_each_parameter_that_the_model_has() {
        let inertia = estimated(0.035, 9.0, Convergence::Open);
        let mut fit = FitUpdate { coulomb_positive: enough(2.3, 0.012), inertia, ..FitUpdate::default() };
        fit.detent_phase.verdict = Verdict::Absent.code();
        let consumers = Consumers::default();
        let facts = Facts { fit: Some(&fit), ..Facts::nothing(&consumers) };
        let text = parameters(&facts);
        assert!(text.contains("## 1 of 7 enough"), "{text}");
        assert!(text.contains("| enough | coulomb positive | 2.300 ± 0.012 mNm |"), "{text}");
        assert!(text.contains("| **not yet** | inertia | 0.0 ± 9.0 mNm s²/rad |"), "{text}");
        assert!(!text.contains("detent phase"), "{text}");
    }

    #[test]
    fn a_fault_says_its_cause() {
        let status = LoopStatus { state: LoopState::Fault.code(), fault: Fault::Speed.code(), ..LoopStatus::default() };
        assert_eq!(state(Some(&status), false), "FAULT: the speed exceeded the rig's limit");
    }

    #[test]
    fn a_control_loop_that_died_is_not_shown_as_running() {
        let status = LoopStatus { state: LoopState::Running.code(), ..LoopStatus::default() };
        assert_eq!(state(Some(&status), false), "running");
        assert!(state(Some(&status), true).contains("GONE"));
    }

    #[test]
    fn a_range_has_three_digits() {
        assert_eq!(three_digits(-1e-5), "0.000");
        assert_eq!([0.299_9, -3.456, 98.76, 12_345.6].map(three_digits), ["0.300", "\u{2212}3.46", "98.8", "12346"]);
    }

    #[test]
    fn a_small_parameter_is_told_with_its_power_of_ten() {
        assert_eq!(with_half_width(3.986e-6, 3e-8), "(3.986 \u{b1} 0.030)e\u{2212}6");
        assert_eq!(with_half_width(-2.301, 0.012), "\u{2212}2.301 \u{b1} 0.012");
    }

    #[test]
    fn a_knob_of_the_paper_is_called_by_its_number() {
        assert_eq!(["3", "my-knob.toml"].map(knob_title), ["Knob 3", "my-knob.toml"]);
    }

    #[test]
    fn counts_have_their_thousands_apart() {
        assert_eq!(grouped(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(grouped(12), "12");
    }
}
