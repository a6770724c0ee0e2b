//! The sheet for a terminal.

use std::path::PathBuf;

use comfy_table::Table;
use sheet::{Detent, Figure, Sheet};

use crate::terminal::{by_reason, digits, interval, table};

pub fn lines(sheet: &Sheet, files: &[PathBuf]) -> Vec<String> {
    let mut lines = vec![heading(sheet, files), figures(sheet).to_string()];
    let missing = sheet.in_order().filter_map(|figure| Some((figure.kind.name, figure.reason.as_deref()?)));
    lines.extend(by_reason(missing).iter().map(|reason| format!("- {reason}")));
    if !sheet.detents.is_empty() {
        lines.push(format!("\n{}", detents(sheet)));
    }
    lines
}

fn heading(sheet: &Sheet, files: &[PathBuf]) -> String {
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

/// The figures that have a value, with the digits that their intervals support.
fn figures(sheet: &Sheet) -> Table {
    let row = |figure: &Figure| {
        let (value, [low, high]) = (figure.value?, figure.ci95?);
        let digits = digits(high - low);
        let cells = [figure.kind.name, &format!("{value:.digits$}"), &interval(figure.ci95, digits), figure.kind.unit];
        Some(cells.map(str::to_owned))
    };
    table(["figure", "value", "95 % interval", "unit"], [1, 2], sheet.in_order().filter_map(row))
}

/// What each detent takes in each direction, in degrees, mNm and mJ; its intervals are in the JSON and on the page.
fn detents(sheet: &Sheet) -> Table {
    let degree = 1_f64.to_radians();
    let row = |detent: &Detent| {
        let cell = |name: &str, unit: f64| {
            let figure = detent.figures.get(name);
            figure.map_or_else(String::new, |figure| in_unit(figure.value, figure.ci95, unit))
        };
        [
            in_unit(detent.angle_rad, detent.angle_rad_ci95, degree),
            detent.direction.to_owned(),
            cell("detent_pitch", degree),
            cell("peak_torque", 1.0),
            cell("trough_torque", 1.0),
            cell("torque_ratio", 1.0),
            cell("detent_stiffness", 1.0),
            cell("detent_energy", 1.0),
        ]
    };
    let header = ["at °", "turning", "pitch °", "peak", "trough", "ratio", "stiffness", "energy"];
    table(header, [0, 2, 3, 4, 5, 6, 7], sheet.detents.iter().map(row))
}

/// A value in a unit with the digits that its interval supports.
fn in_unit(value: f64, [low, high]: [f64; 2], unit: f64) -> String {
    let digits = digits((high - low) / unit);
    format!("{:.digits$}", value / unit)
}
