//! Results as JSON.

use dynamics::Axis;
use serde::Serialize;
use serde_json::Value;

/// The value of `made_by` in every result, which marks a file that a later result may replace.
pub const MADE_BY: &str = "haptic-camera";

/// The result of what has an axis, in its names and units.
///
/// # Errors
/// As [`to_json`].
pub fn to_json_on(axis: Axis, result: &impl Serialize) -> Result<String, serde_json::Error> {
    let text = to_json(result)?;
    if axis.is_rotary() {
        return Ok(text);
    }
    serde_json::to_string_pretty(&in_words_of(axis, serde_json::from_str(&text)?, false))
}

/// Keys whose values are names that others gave.
const AS_GIVEN: [&str; 5] = ["title", "source", "capture", "captures", "model"];

/// Translates keys and texts into the words of an axis, except for given names and the unit of a phase.
fn in_words_of(axis: Axis, value: Value, is_phase: bool) -> Value {
    match value {
        Value::Object(map) => {
            let entry = |(key, value): (String, Value)| {
                let is_phase = is_phase || key.contains("phase");
                let is_name = match &value {
                    Value::Array(values) => values.iter().all(Value::is_string),
                    one => one.is_string(),
                };
                let keep = is_name && AS_GIVEN.contains(&key.as_str());
                let value = if keep { value } else { in_words_of(axis, value, is_phase) };
                (axis.words(&key).into_owned(), value)
            };
            Value::Object(map.into_iter().map(entry).collect())
        }
        Value::Array(values) => {
            Value::Array(values.into_iter().map(|value| in_words_of(axis, value, is_phase)).collect())
        }
        Value::String(text) if is_phase && text == "rad" => Value::String(text),
        Value::String(text) => Value::String(axis.words(&text).into_owned()),
        other => other,
    }
}

/// A result as JSON: its own keys, and `made_by`.
///
/// # Errors
/// Where a result cannot be written as JSON, which those of this crate always can.
pub fn to_json(result: &impl Serialize) -> Result<String, serde_json::Error> {
    #[derive(Serialize)]
    struct Marked<'a, Content> {
        made_by: &'static str,
        #[serde(flatten)]
        content: &'a Content,
    }
    serde_json::to_string_pretty(&Marked { made_by: MADE_BY, content: result })
}
