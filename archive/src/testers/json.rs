//! A press and its return as JSON: `down_x`, `down_y`, `up_x` and `up_y` in mm and gf.

use std::path::Path;

use shared_types::{Axis, Quantity};

use super::{Curve, wrong};
use crate::capture::first_bytes;
use crate::error::ArchiveError;

/// Bytes among which the first letter must be.
const HEAD: usize = 64;

#[derive(serde::Deserialize)]
struct PressAndReturn {
    down_x: Vec<f64>,
    down_y: Vec<f64>,
    up_x: Vec<f64>,
    up_y: Vec<f64>,
}

/// Whether a file begins as a JSON object does.
pub(super) fn is_json(path: &Path) -> Result<bool, ArchiveError> {
    let head = first_bytes(path, HEAD)?;
    let first = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head).trim_ascii_start().first();
    Ok(first == Some(&b'{'))
}

/// Reads the press, then the return.
pub(super) fn read(path: &Path) -> Result<Curve, ArchiveError> {
    let text = foreign_files::read_text(path).map_err(|error| ArchiveError::file(path, error))?;
    let PressAndReturn { down_x, down_y, mut up_x, mut up_y } =
        serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|error| {
            wrong(path, format!(
                "of JSON files only presses are read, with number lists down_x, down_y, up_x and up_y ({error}); save a capture as CSV or MCAP"
            ))
        })?;
    if down_x.len() != down_y.len() || up_x.len() != up_y.len() {
        return Err(wrong(path, "down_x and down_y, or up_x and up_y, differ in length".to_owned()));
    }
    // Some list the return from the top on.
    if up_x.first() < up_x.last() {
        up_x.reverse();
        up_y.reverse();
    }
    let gram_force = Quantity::Force.factor("gf").unwrap_or(1.0);
    Ok(Curve {
        axis: Axis::Linear,
        position: [down_x, up_x].concat(),
        load: down_y.into_iter().chain(up_y).map(|force| force * gram_force).collect(),
        ..Curve::default()
    })
}
