//! The check for a terminal.

use comfy_table::Table;

use super::Agreement;
use crate::terminal::{self, digits};

/// What was seen beside what was fitted.
pub fn table(agreement: &[Agreement]) -> Table {
    let mut table = terminal::table(["quantity", "seen", "95 % interval", "fitted", "difference", "unit"], 1..5);
    for row in agreement {
        let width = row.ci95.map_or(1e-3 * row.checked.abs(), |[low, high]| high - low);
        let digits = digits(width);
        table.add_row([
            row.quantity.to_owned(),
            format!("{:.digits$}", row.checked),
            row.ci95.map_or_else(String::new, |[low, high]| format!("{low:.digits$} to {high:.digits$}")),
            row.model.map_or_else(String::new, |model| format!("{model:.digits$}")),
            row.difference_percent.map_or_else(String::new, |percent| format!("{percent:+.1} %")),
            row.unit.to_owned(),
        ]);
    }
    table
}
