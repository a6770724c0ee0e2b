//! A table as text of two columns.

use super::TorqueTableError;

const HEADER: [&str; 2] = ["angle_rad", "torque_mnm"];

/// Angles and torques of a text with the header `angle_rad,torque_mnm`; empty lines are passed over.
pub(super) fn columns(text: &str) -> Result<(Vec<f64>, Vec<f64>), TorqueTableError> {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let header = lines.next().ok_or(TorqueTableError::Header)?.1;
    if !header.split(',').map(str::trim).eq(HEADER) {
        return Err(TorqueTableError::Header);
    }
    let point = |(index, line): (usize, &str)| {
        let number = |cell: &str| cell.trim().parse::<f64>().ok();
        let pair = line.split_once(',').and_then(|(angle, torque)| Some((number(angle)?, number(torque)?)));
        pair.ok_or(TorqueTableError::Line { line: index + 1 })
    };
    lines.map(point).collect()
}
