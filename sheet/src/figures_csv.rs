//! The figures of a sheet as a table.

use std::fmt::Write as _;

use crate::Sheet;

/// The first line of a table of figures.
pub const FIGURES_HEADER: &str = "figure,angle_rad,direction,value,unit,ci95_low,ci95_high,definition\n";

impl Sheet {
    /// The figures as a table, one row a figure; after those of the whole control, those of each detent with its angle and direction.
    #[must_use]
    pub fn figures_csv(&self) -> String {
        let mut text = FIGURES_HEADER.to_owned();
        let number = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        // Writing to a string does not fail.
        for figure in self.in_order() {
            let kind = figure.kind;
            let [low, high] = [0, 1].map(|end| number(figure.ci95.map(|ends| ends[end])));
            let definition = kind.definition.replace('"', "\"\"");
            let _ =
                writeln!(text, "{},,,{},{},{low},{high},\"{definition}\"", kind.name, number(figure.value), kind.unit);
        }
        for detent in &self.detents {
            for (name, figure) in &detent.figures {
                let [low, high] = figure.ci95;
                let (angle, direction) = (detent.angle_rad, detent.direction);
                let _ = writeln!(text, "{name},{angle},{direction},{},{},{low},{high},", figure.value, figure.unit);
            }
        }
        text
    }
}
