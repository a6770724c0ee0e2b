//! How captures of the same knob repeat, as a table for an 80-column terminal.

use comfy_table::Table;
use identification::{Agreement, Average};

use crate::terminal::{digits, table};

/// Most captures whose values stand side by side; of more, the differences alone.
const SIDE_BY_SIDE: usize = 3;

/// Each parameter's values, their difference, and what their intervals allow.
pub fn repeatability_table(average: &Average) -> Table {
    let mut header = vec!["parameter".to_owned()];
    let shown = if average.captures <= SIDE_BY_SIDE { average.captures } else { 0 };
    header.extend((1..=shown).map(|number| format!("capture {number}")));
    header.extend(["difference", "allowed", "ratio", "unit"].map(str::to_owned));
    let mut table = table(header, 1..shown + 4);
    for parameter in &average.fit.parameters.0 {
        let Some(record) = average.repeatability.get(parameter.name) else { continue };
        let digits = digits(record.difference_ci95);
        let mut row = vec![parameter.name.to_owned()];
        row.extend(record.values.iter().take(shown).map(|value| match value {
            Some(value) => format!("{value:.digits$}"),
            None => "-".to_owned(),
        }));
        row.push(format!("{:.digits$}", record.difference));
        row.push(format!("±{:.digits$}", record.difference_ci95));
        row.push(format!("{:.2}", record.ratio));
        row.push(record.unit.to_owned());
        table.add_row(row);
    }
    table
}

/// Whether the captures agree as a whole.
pub fn agreement_line(agreement: Agreement) -> String {
    let words = if agreement.agrees() { "agree within" } else { "differ by more than" };
    format!(
        "the captures {words} their intervals: chi-squared {:.1} over {} degrees of freedom (p = {:.2e}), Birge ratio {:.2}",
        agreement.chi_squared, agreement.degrees_of_freedom, agreement.probability, agreement.birge_ratio
    )
}
