//! The text next to the plots of a finished capture: what it is, and what the fit tells.

use archive::Capture;
use identification::{Fit, Parameter};

use crate::extent;
use crate::numbers::{self, alarmed, grouped, three_figures, with_half_width};
use crate::summary::knob_title;

/// Largest difference between the halves of an interval that is written as value ± half width, as a share of it.
const SYMMETRIC: f64 = 0.01;

/// The text as Markdown; `fit` is the fit, or one sentence on why there is none.
pub fn markdown(capture: &Capture, fit: &Result<Fit, String>) -> String {
    let columns = [
        ("angle_rad", Some(&capture.angle_rad)),
        ("velocity_rad_s", capture.velocity_rad_s.as_ref()),
        ("acceleration_rad_s2", capture.acceleration_rad_s2.as_ref()),
        ("torque_mnm", Some(&capture.torque_mnm)),
    ];
    let extents = columns.map(|(name, column)| (name, column.and_then(|column| extent::of(column.iter().copied()))));
    let ranges = numbers::ranges("signal", extents);
    let (parameters, remarks) = match fit {
        Ok(fit) => (parameters(fit), remarks(fit)),
        Err(reason) => (format!("**No model:** {reason}\n\n"), String::new()),
    };
    head(capture) + &parameters + &ranges + &remarks
}

fn head(capture: &Capture) -> String {
    let file = capture.file_name();
    let rate = rate(capture.rate_hz);
    let title = match &capture.description {
        Some(run) => format!("# {}\n\non **{}**, {rate}\n\n{file}", knob_title(&run.knob), run.apparatus),
        None => format!("# {file}\n\ntable, {rate}"),
    };
    let duration_s = capture.t_s.last().zip(capture.t_s.first()).map_or(0.0, |(last, first)| last - first);
    let samples = grouped(capture.len() as u64);
    let absent = match capture.ticks_without_sample() {
        0 => String::new(),
        absent => format!("{} ticks without a sample\n\n", alarmed(absent)),
    };
    format!("{title}\n\n### {duration_s:.1} s \u{2014} {samples} samples\n\n{absent}")
}

/// In whole Hz or in kHz with as many digits as it has.
fn rate(rate_hz: f64) -> String {
    if rate_hz < 1_000.0 { format!("{rate_hz:.0} Hz") } else { format!("{} kHz", (rate_hz.round() / 1_000.0)) }
}

fn parameters(fit: &Fit) -> String {
    // Where the torque was measured over the angle, nobody looked for detents, and the scale of what was measured is 1.
    let is_looked_for = |parameter: &&Parameter| {
        fit.characteristics.is_empty()
            || !(parameter.name.starts_with("detent_") || parameter.name.ends_with("_characteristic_scale"))
    };
    let row = |parameter: &Parameter| {
        let name = parameter.name.replace('_', " ");
        format!("| {name} | {} | {} |\n", value_and_interval(parameter), parameter.unit)
    };
    let rows: String = fit.parameters.0.iter().filter(is_looked_for).map(row).collect();
    format!(
        "| parameter | value ± 95 % | unit |\n|---|---:|---|\n{rows}\n\
         residual **{:.3} mNm** RMS, {:.2} % of the torque\n\n",
        fit.residual_rms_mnm, fit.relative_error_percent
    )
}

/// `2.301 ± 0.012`; an interval that lies unevenly about its value with both ends.
fn value_and_interval(parameter: &Parameter) -> String {
    match (parameter.value, parameter.ci95) {
        (None, _) => "*not identifiable*".to_owned(),
        (Some(value), None) => three_figures(value),
        (Some(value), Some([low, high])) => {
            let half_width = (high - low) / 2.0;
            let is_symmetric = ((high - value) - (value - low)).abs() <= SYMMETRIC * half_width;
            let [middle, low, high] = [value, low, high].map(three_figures);
            if is_symmetric { with_half_width(value, half_width) } else { format!("{middle} ({low} to {high})") }
        }
    }
}

/// Why parameters are not identifiable, grouped by reason, and other remarks.
fn remarks(fit: &Fit) -> String {
    let mut reasons: Vec<(&str, Vec<String>)> = Vec::new();
    for parameter in &fit.parameters.0 {
        let Some(reason) = &parameter.reason else { continue };
        let name = parameter.name.replace('_', " ");
        match reasons.iter_mut().find(|(known, _)| known == reason) {
            Some((_, names)) => names.push(name),
            None => reasons.push((reason, vec![name])),
        }
    }
    let reasons = reasons.into_iter().map(|(reason, names)| format!("**{}**: {reason}", names.join(", ")));
    reasons.chain(fit.notes.iter().cloned()).map(|remark| format!("- {remark}\n")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(value: Option<f64>, ci95: Option<[f64; 2]>) -> Parameter {
        Parameter { name: "inertia", value, unit: "mNm s²/rad", ci95, ci95_textbook: None, reason: None }
    }

    #[test]
    fn an_interval_that_ends_at_zero_is_written_with_both_ends() {
        let held = parameter(Some(0.0), Some([0.0, 0.25]));
        assert_eq!(value_and_interval(&held), "0.000 (0.000 to 0.250)");
        assert_eq!(value_and_interval(&parameter(Some(2.3), Some([2.288, 2.312]))), "2.300 ± 0.012");
        assert_eq!(value_and_interval(&parameter(None, None)), "*not identifiable*");
    }

    #[test]
    fn a_rate_is_written_without_idle_digits() {
        assert_eq!([10_000.0, 1_024.0, 66.67].map(rate), ["10 kHz", "1.024 kHz", "67 Hz"]);
    }
}
