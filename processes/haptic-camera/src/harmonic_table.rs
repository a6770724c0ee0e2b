//! The sinusoids of the angle that a fit found.

use comfy_table::Table;
use identification::Fit;

use crate::terminal::table;

/// The sinusoids, strongest first; `None` if there are none.
pub fn harmonic_table(fit: &Fit) -> Option<Table> {
    let harmonics = &fit.detent_harmonics;
    let first = harmonics.first()?;
    let whole_model = first.relative_error_percent.is_some();
    let share = if whole_model { "relative error with it %" } else { "of the residual %" };
    let mut table = table(["per turn", "of the detent", "amplitude mNm", "phase rad", share], 0..5);
    for harmonic in harmonics {
        // Where every harmonic is a whole number per turn, it is written as one.
        let digits = if harmonics.iter().all(|one| one.per_turn.fract() == 0.0) { 0 } else { 3 };
        table.add_row([
            format!("{:.digits$}", harmonic.per_turn),
            harmonic.order.map_or_else(String::new, |order| format!("{order}×")),
            with_interval(harmonic.amplitude_mnm, harmonic.amplitude_ci95_mnm),
            with_interval(harmonic.phase_rad, harmonic.phase_ci95_rad),
            format!("{:.2}", harmonic.relative_error_percent.unwrap_or(harmonic.explains_percent)),
        ]);
    }
    Some(table)
}

fn with_interval(value: f64, ci95: Option<[f64; 2]>) -> String {
    ci95.map_or_else(|| format!("{value:.3}"), |[low, high]| format!("{value:.3} ± {:.3}", 0.5 * (high - low)))
}
