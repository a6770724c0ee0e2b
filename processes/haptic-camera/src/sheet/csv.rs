//! The figures as a table of comma-separated text.

use std::fmt::Write as _;

use sheet::Sheet;

use crate::outputs::FIGURES_HEADER;

/// One row a figure; after those of the whole control, those of each detent with its angle and direction.
pub fn text(sheet: &Sheet) -> String {
    let mut text = FIGURES_HEADER.to_owned();
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    // Writing to a string does not fail.
    for figure in sheet.in_order() {
        let kind = figure.kind;
        let [low, high] = [0, 1].map(|end| number(figure.ci95.map(|ends| ends[end])));
        let definition = kind.definition.replace('"', "\"\"");
        let _ = writeln!(text, "{},,,{},{},{low},{high},\"{definition}\"", kind.name, number(figure.value), kind.unit);
    }
    for detent in &sheet.detents {
        for (name, figure) in &detent.figures {
            let [low, high] = figure.ci95;
            let (angle, direction) = (detent.angle_rad, detent.direction);
            let _ = writeln!(text, "{name},{angle},{direction},{},{},{low},{high},", figure.value, figure.unit);
        }
    }
    text
}
