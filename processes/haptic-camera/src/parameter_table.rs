//! A fit's parameters as a table for an 80-column terminal.

use comfy_table::Table;
use dynamics::effects::detent::canonical;
use dynamics::{Model, effects};
use identification::{Fit, Parameter};

use crate::terminal::{self, by_reason, table};

/// Parameters with intervals, and the true values where they are known.
pub fn parameter_table(fit: &Fit, truth: Option<&Model>) -> Table {
    let mut header = vec!["parameter", "fitted", "95 % interval", "unit"];
    if truth.is_some() {
        header.extend(["true", ""]);
    }
    let mut table = table(header, [1, 2, 4]);
    for parameter in &fit.parameters.0 {
        let digits = digits(parameter);
        let (value, interval) = match (parameter.value, parameter.ci95) {
            (Some(value), Some([low, high])) => {
                (format!("{value:.digits$}"), format!("{low:.digits$} to {high:.digits$}"))
            }
            (Some(value), None) => (format!("{value:.digits$}"), String::new()),
            (None, _) => ("-".to_owned(), "not identifiable".to_owned()),
        };
        let mut row = vec![parameter.name.to_owned(), value, interval, parameter.unit.to_owned()];
        if let Some(model) = truth {
            row.extend(truth_cells(parameter, model, digits));
        }
        table.add_row(row);
    }
    table
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
fn digits(parameter: &Parameter) -> usize {
    terminal::digits(match (parameter.ci95, parameter.value) {
        (Some([low, high]), _) if high > low => high - low,
        (_, value) => 1e-3 * value.unwrap_or(0.0).abs(),
    })
}
