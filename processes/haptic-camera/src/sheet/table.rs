//! The sheet for a terminal.

use std::path::PathBuf;

use comfy_table::Table;
use sheet::{Figure, Sheet};

use crate::terminal::{by_reason, digits, table};

/// What the sheet is of.
pub fn heading(sheet: &Sheet, files: &[PathBuf]) -> String {
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    match files {
        [only] if sheet.runs > 1 => {
            let name = operator::one_line(&name(only));
            format!("{name}, mean of {} presses, 95 % intervals of one more of them", sheet.runs)
        }
        [only] => format!("{}, 95 % intervals from the noise of a single curve", operator::one_line(&name(only))),
        several => {
            let folder = several[0].parent().and_then(|folder| folder.file_name());
            let of = folder.map_or_else(String::new, |folder| format!(" of {}", folder.to_string_lossy()));
            operator::one_line(&format!("mean of {} curves{of}, 95 % prediction intervals for another one", sheet.runs))
        }
    }
}

/// The figures that have a value.
pub fn figures(sheet: &Sheet) -> Table {
    let mut table = table(["figure", "value", "95 % interval", "unit"], [1, 2]);
    for figure in sheet.in_order() {
        if let Some([value, interval]) = cells(figure) {
            table.add_row([figure.kind.name.to_owned(), value, interval, figure.kind.unit.to_owned()]);
        }
    }
    table
}

/// What each detent takes in each direction, in degrees, mNm and mJ; its intervals are in the JSON and on the page.
pub fn detents(sheet: &Sheet) -> Table {
    let header = ["at °", "turning", "pitch °", "peak", "trough", "ratio", "stiffness", "energy"];
    let mut table = table(header, [0, 2, 3, 4, 5, 6, 7]);
    for detent in &sheet.detents {
        let cell = |name: &str, unit: f64| {
            let figure = detent.figures.get(name);
            figure.map_or_else(String::new, |figure| {
                let digits = digits((figure.ci95[1] - figure.ci95[0]) / unit);
                format!("{:.digits$}", figure.value / unit)
            })
        };
        let degree = 1_f64.to_radians();
        let width = detent.angle_rad_ci95[1] - detent.angle_rad_ci95[0];
        let digits = digits(width / degree);
        table.add_row([
            format!("{:.digits$}", detent.angle_rad / degree),
            detent.direction.to_owned(),
            cell("detent_pitch", degree),
            cell("peak_torque", 1.0),
            cell("trough_torque", 1.0),
            cell("torque_ratio", 1.0),
            cell("detent_stiffness", 1.0),
            cell("detent_energy", 1.0),
        ]);
    }
    table
}

/// Value and interval with the digits that the interval supports.
fn cells(figure: &Figure) -> Option<[String; 2]> {
    let (value, [low, high]) = (figure.value?, figure.ci95?);
    let digits = digits(high - low);
    Some([format!("{value:.digits$}"), format!("{low:.digits$} to {high:.digits$}")])
}

/// Why figures are missing, each reason once.
pub fn reasons(sheet: &Sheet) -> Vec<String> {
    by_reason(sheet.in_order().filter_map(|figure| Some((figure.kind.name, figure.reason.as_deref()?))))
}
