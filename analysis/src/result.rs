//! Results as JSON.

use serde::Serialize;

/// What every result says under `made_by`; by it a file is known to be replaceable by a later one.
pub const MADE_BY: &str = "haptic-camera";

/// A result as JSON, under its keys and `made_by`.
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
