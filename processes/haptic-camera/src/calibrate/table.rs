//! What a calibration learnt, for a terminal.

use comfy_table::Table;
use dynamics::Calibration;
use identification::calibration::{Calibrated, CoggingEstimate};

use crate::terminal::{self, digits};

/// Each quantity as it was believed and as it was found, with its interval.
pub fn table(known: &Calibration, calibrated: &Calibrated) -> Table {
    let mut table = terminal::table(["quantity", "before", "found", "95 %", "unit"], 1..4);
    let before = toml::Table::try_from(known).unwrap_or_default();
    for estimate in &calibrated.estimates {
        // Delays are fractions of a sample: microseconds read better.
        let (factor, unit) = if estimate.unit == "s" { (1e6, "µs") } else { (1.0, estimate.unit) };
        let digits = digits(factor * estimate.half_width);
        let believed = before.get(estimate.quantity).and_then(toml::Value::as_float);
        table.add_row([
            estimate.quantity.to_owned(),
            believed.map_or_else(String::new, |value| format!("{:.digits$}", factor * value)),
            format!("{:.digits$}", factor * estimate.value),
            format!("±{:.digits$}", factor * estimate.half_width),
            unit.to_owned(),
        ]);
    }
    table
}

/// Each harmonic of a motor's cogging with its intervals; one line that says so where there is none.
pub fn cogging_lines(cogging: &[CoggingEstimate]) -> Vec<String> {
    if cogging.is_empty() {
        return vec!["none".to_owned()];
    }
    let line = |harmonic: &CoggingEstimate| {
        let CoggingEstimate { per_turn, torque_mnm, torque_half_width_mnm, phase_rad, phase_half_width_rad } = harmonic;
        let (of_torque, of_phase) = (digits(*torque_half_width_mnm), digits(*phase_half_width_rad));
        format!(
            "{per_turn} per turn of {torque_mnm:.of_torque$} ± {torque_half_width_mnm:.of_torque$} mNm, phase \
             {phase_rad:.of_phase$} ± {phase_half_width_rad:.of_phase$} rad"
        )
    };
    cogging.iter().map(line).collect()
}
