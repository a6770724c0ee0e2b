//! The sheet for a terminal.

use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use sheet::{Figure, Sheet};

use crate::repeatability::digits;

/// What the sheet is of.
pub fn heading(sheet: &Sheet, files: &[PathBuf]) -> String {
    let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    match files {
        [only] => format!("{}, 95 % intervals from the noise of one curve", operator::one_line(&name(only))),
        several => {
            let folder = several[0].parent().and_then(|folder| folder.file_name());
            let of = folder.map_or_else(String::new, |folder| format!(" of {}", folder.to_string_lossy()));
            operator::one_line(&format!("mean of {} curves{of}, 95 % intervals of one more of them", sheet.runs))
        }
    }
}

/// The figures that are told.
pub fn figures(sheet: &Sheet) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(["figure", "value", "95 % interval", "unit"]);
    for kind in sheet::kinds() {
        let Some(figure) = sheet.figure(kind) else { continue };
        if let Some([value, interval]) = cells(figure) {
            table.add_row([kind.name.to_owned(), value, interval, kind.unit.to_owned()]);
        }
    }
    for column in [1, 2] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
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
pub fn untold(sheet: &Sheet) -> Vec<String> {
    let mut reasons: Vec<(&str, Vec<&str>)> = Vec::new();
    for kind in sheet::kinds() {
        let Some(reason) = sheet.figure(kind).and_then(|figure| figure.reason.as_deref()) else { continue };
        match reasons.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, names)) => names.push(kind.name),
            None => reasons.push((reason, vec![kind.name])),
        }
    }
    reasons.iter().map(|(reason, names)| format!("- {}: {reason}", names.join(", "))).collect()
}
