//! Figures of many parts in Q-DAS's transfer format (AQDEF), as `.dfq` files have it.

use std::fmt::Write as _;

use crate::figure::FigureKind;
use crate::specification::Limits;

/// Between the fields of a value, and between the values of a part.
const FIELD: char = '\u{14}';
const VALUE: char = '\u{f}';
/// What marks a value that was not measured (AQDEF, attribute K0002).
const NOT_MEASURED: &str = "256";
/// Decimals with which values are shown (K2022).
const DECIMALS: u32 = 4;

/// The file's statement of its origin (K1900), which marks it as one that a later file may replace.
pub const QDAS_REMARK: &str = "made by haptic-camera";

/// A part's figures, and when it was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct QdasRow {
    /// Date and time, as `DD.MM.YYYY/hh:mm:ss`.
    pub measured_at: String,
    /// Its figures in the order of the characteristics; `None` for one that the curve does not tell.
    pub values: Vec<Option<f64>>,
}

/// The text of a `.dfq` file with those characteristics and parts.
#[must_use]
pub fn qdas(name: &str, characteristics: &[(&'static FigureKind, Limits)], rows: &[QdasRow]) -> String {
    // Tells readers the encoding, which they would otherwise guess at among so many separators that are no letters.
    let mut text = String::from("\u{feff}");
    let mut line = |key: &str, value: &str| {
        // A line break within a value would begin another field.
        let value: String = value.chars().map(|letter| if letter.is_control() { ' ' } else { letter }).collect();
        // Writing to a string does not fail.
        let _ = write!(text, "{key} {value}\r\n");
    };
    line("K0100", &characteristics.len().to_string());
    line("K1001", if name.is_empty() { "part" } else { name });
    line("K1002", if name.is_empty() { "part" } else { name });
    line("K1900", QDAS_REMARK);
    for (number, (kind, limits)) in (1..).zip(characteristics) {
        line(&format!("K2001/{number}"), &number.to_string());
        line(&format!("K2002/{number}"), kind.name);
        line(&format!("K2004/{number}"), "0");
        line(&format!("K2022/{number}"), &DECIMALS.to_string());
        if let Some(min) = limits.min {
            line(&format!("K2110/{number}"), &min.to_string());
        }
        if let Some(max) = limits.max {
            line(&format!("K2111/{number}"), &max.to_string());
        }
        line(&format!("K2142/{number}"), if kind.unit.is_empty() { "1" } else { kind.unit });
    }
    for QdasRow { measured_at, values } in rows {
        let cell = |value: &Option<f64>| match value {
            Some(value) => format!("{value}{FIELD}0{FIELD}{measured_at}"),
            None => format!("0{FIELD}{NOT_MEASURED}{FIELD}{measured_at}"),
        };
        text.push_str(&values.iter().map(cell).collect::<Vec<_>>().join(&VALUE.to_string()));
        text.push_str("\r\n");
    }
    text
}
