//! A fit as tables for a terminal.

use comfy_table::Table;
use dynamics::effects::detent::canonical;
use dynamics::{Model, effects};
use identification::{Agreement, Average, Fit, Parameter};

use crate::terminal::{by_reason, digits, interval, table};

/// Parameters with intervals, and the true values where they are known.
pub fn parameter_table(fit: &Fit, truth: Option<&Model>) -> Table {
    let mut header = vec!["parameter", "fitted", "95 % interval", "unit"];
    if truth.is_some() {
        header.extend(["true", ""]);
    }
    let row = |parameter: &Parameter| {
        let digits = digits_of(parameter);
        let (value, interval) = match parameter.value {
            Some(value) => (format!("{value:.digits$}"), interval(parameter.ci95, digits)),
            None => ("-".to_owned(), "not identifiable".to_owned()),
        };
        let mut row = vec![parameter.name.to_owned(), value, interval, parameter.unit.to_owned()];
        row.extend(truth.into_iter().flat_map(|model| truth_cells(parameter, model, digits)));
        row
    };
    table(header, [1, 2, 4], fit.parameters.0.iter().map(row))
}

/// Why parameters are not identifiable, a line for each reason.
pub fn reasons(fit: &Fit) -> Vec<String> {
    by_reason(fit.parameters.0.iter().filter_map(|parameter| Some((parameter.name, parameter.reason.as_deref()?))))
}

/// The true value as the fit would write it: detents with positive amplitude.
pub fn true_value(model: &Model, name: &str) -> Option<f64> {
    let detent = model.effect(effects::detent::KIND.name).map(|detent| {
        let values = detent.values();
        canonical(values[0], values[2])
    });
    match (name, detent) {
        ("detent_amplitude", Some((amplitude, _))) => Some(amplitude),
        ("detent_phase", Some((_, phase))) => Some(phase),
        _ => model.parameter(name),
    }
}

fn truth_cells(parameter: &Parameter, model: &Model, digits: usize) -> [String; 2] {
    let Some(value) = true_value(model, parameter.name) else { return ["none".to_owned(), String::new()] };
    let inside = match parameter.ci95 {
        Some([low, high]) if (low..=high).contains(&value) => "in",
        Some(_) => "out",
        None => "",
    };
    [format!("{value:.digits$}"), inside.to_owned()]
}

/// Decimals that show the interval's width with two digits.
fn digits_of(parameter: &Parameter) -> usize {
    digits(match (parameter.ci95, parameter.value) {
        (Some([low, high]), _) if high > low => high - low,
        (_, value) => 1e-3 * value.unwrap_or(0.0).abs(),
    })
}

/// The sinusoids, strongest first; `None` if there are none.
pub fn harmonic_table(fit: &Fit) -> Option<Table> {
    let harmonics = &fit.detent_harmonics;
    let first = harmonics.first()?;
    let whole_model = first.relative_error_percent.is_some();
    let share = if whole_model { "relative error with it %" } else { "of the residual %" };
    // Where every harmonic is a whole number per turn, it is written as one.
    let digits = if harmonics.iter().all(|one| one.per_turn.fract() == 0.0) { 0 } else { 3 };
    let rows = harmonics.iter().map(|harmonic| {
        [
            format!("{:.digits$}", harmonic.per_turn),
            harmonic.order.map_or_else(String::new, |order| format!("{order}×")),
            with_interval(harmonic.amplitude_mnm, harmonic.amplitude_ci95_mnm),
            with_interval(harmonic.phase_rad, harmonic.phase_ci95_rad),
            format!("{:.2}", harmonic.relative_error_percent.unwrap_or(harmonic.explains_percent)),
        ]
    });
    Some(table(["per turn", "of the detent", "amplitude mNm", "phase rad", share], 0..5, rows))
}

fn with_interval(value: f64, ci95: Option<[f64; 2]>) -> String {
    ci95.map_or_else(|| format!("{value:.3}"), |[low, high]| format!("{value:.3} ± {:.3}", 0.5 * (high - low)))
}

/// Most captures whose values stand side by side; of more, the differences alone.
const SIDE_BY_SIDE: usize = 3;

/// Each parameter's values, their difference, and what their intervals allow.
pub fn repeatability_table(average: &Average) -> Table {
    let mut header = vec!["parameter".to_owned()];
    let shown = if average.captures <= SIDE_BY_SIDE { average.captures } else { 0 };
    header.extend((1..=shown).map(|number| format!("capture {number}")));
    header.extend(["difference", "allowed", "ratio", "unit"].map(str::to_owned));
    let row = |parameter: &Parameter| {
        let record = average.repeatability.get(parameter.name)?;
        let digits = digits(record.difference_ci95);
        let value = |value: &Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.digits$}"));
        let mut row = vec![parameter.name.to_owned()];
        row.extend(record.values.iter().take(shown).map(value));
        row.extend([format!("{:.digits$}", record.difference), format!("±{:.digits$}", record.difference_ci95)]);
        row.extend([format!("{:.2}", record.ratio), record.unit.to_owned()]);
        Some(row)
    };
    table(header, 1..shown + 4, average.fit.parameters.0.iter().filter_map(row))
}

pub fn agreement_line(agreement: Agreement) -> String {
    let words = if agreement.agrees() { "agree within" } else { "differ by more than" };
    format!(
        "the captures {words} their intervals: chi-squared {:.1} over {} degrees of freedom (p = {:.2e}), Birge ratio {:.2}",
        agreement.chi_squared, agreement.degrees_of_freedom, agreement.probability, agreement.birge_ratio
    )
}
