//! What was found, put into a rig's file: its numbers change, its comments stay.

use std::path::Path;

use anyhow::Context as _;
use archive::whole_file::Replace;
use dynamics::Axis;
use toml_edit::{DocumentMut, Item, Value};

use crate::outputs;

/// What is known of a rig once it has turned.
pub(super) struct Known {
    pub(super) motor_inertia: Option<f64>,
    pub(super) angle_step_rad: Option<f64>,
}

/// Writes it into the rig file `file`, as `path`.
///
/// # Errors
/// When the file has its calibration elsewhere, or cannot be written.
pub(super) fn write(file: &Path, path: &Path, axis: Axis, known: &Known) -> anyhow::Result<()> {
    let text = std::fs::read_to_string(file).with_context(|| format!("{} cannot be read", file.display()))?;
    let changed = with(&text, axis, known).with_context(|| format!("{} is not changed", file.display()))?;
    // In its place it is the file that was read; elsewhere nothing may lie there.
    let may_replace = if path == file { Replace::Anything } else { Replace::Nothing };
    outputs::write(path, may_replace, &changed)
}

/// The text of a rig file with what is known in it.
fn with(text: &str, axis: Axis, known: &Known) -> anyhow::Result<String> {
    let mut document: DocumentMut = text.parse().context("it is no TOML")?;
    anyhow::ensure!(
        !document.contains_key("calibration_file"),
        "its calibration is in another file (calibration_file): enter the values there"
    );
    let table = document.entry("calibration").or_insert(toml_edit::table());
    let found = [("motor_inertia", known.motor_inertia), ("angle_step_rad", known.angle_step_rad)];
    for (key, number) in found.into_iter().filter_map(|(key, number)| Some((axis.words(key), rounded(number?)))) {
        let key = key.as_ref();
        match table.get_mut(key).and_then(Item::as_value_mut) {
            // What a maker says of an encoder is exacter than what was seen.
            Some(before) if before.as_float().is_some_and(|before| (before / number - 1.0).abs() < SAME_SHARE) => {}
            Some(before) => {
                let comment = before.decor().clone();
                *before = Value::from(number);
                *before.decor_mut() = comment;
            }
            None => table[key] = toml_edit::value(number),
        }
    }
    Ok(document.to_string())
}

/// Share by which a number of the file may differ from what was found and stay.
const SAME_SHARE: f64 = 1e-3;

/// Four digits: no more are known.
fn rounded(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use dynamics::Axis;

    use super::{Known, with};

    #[test]
    fn numbers_change_and_comments_stay() {
        let known = Known { motor_inertia: Some(0.020_023_4), angle_step_rad: Some(0.001) };
        let text = "# mine\nname = \"a\"\n\n[calibration]\nmotor_inertia = 0.5   # a guess\n";
        let changed =
            "# mine\nname = \"a\"\n\n[calibration]\nmotor_inertia = 0.02002   # a guess\nangle_step_rad = 0.001\n";
        assert_eq!(with(text, Axis::Rotary, &known).unwrap(), changed);
        assert!(
            with("name = \"a\"\n", Axis::Rotary, &known).unwrap().contains("[calibration]\nmotor_inertia = 0.02002\n")
        );
        assert!(with("name = \"a\"\n", Axis::Linear, &known).unwrap().contains("\ntravel_step_mm = 0.001\n"));
        assert!(with("calibration_file = \"b.toml\"\n", Axis::Rotary, &known).is_err());
    }
}
