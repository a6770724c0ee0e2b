//! Torque and residual over time.

use identification::diagnosis::Row;
use rerun::datatypes::Rgba32;
use rerun::{RecordingStream, Scalars, TimeColumn};

use super::CaptureRows;
use crate::drawing::TIMELINE;
use crate::palette::{MEASURED, MODEL, NEUTRAL};
use crate::series_styles::line;

/// A series of a capture: its quantity, its name, its colour, and its value in a row.
type Series = (&'static str, &'static str, Rgba32, fn(&Row) -> f64);

/// Measured torque and what the first and the final model predict, mNm; what they leave, mNm; the motion, rad and rad/s.
const SERIES: [Series; 7] = [
    ("torque", "predicted_before_mnm", NEUTRAL, |row| row.torque_mnm - row.residual_before_mnm),
    ("torque", "predicted_after_mnm", MODEL, |row| row.torque_mnm - row.residual_after_mnm),
    ("torque", "measured_mnm", MEASURED, |row| row.torque_mnm),
    ("residual", "before_mnm", NEUTRAL, |row| row.residual_before_mnm),
    ("residual", "after_mnm", MODEL, |row| row.residual_after_mnm),
    ("motion", "angle_rad", MEASURED, |row| row.angle_rad),
    ("motion", "velocity_rad_s", MEASURED, |row| row.velocity_rad_s),
];

/// Longest time between two rows that a line joins, relative to the usual time: there are no rows where the knob may stick.
const GAP: f64 = 5.0;

/// Draws the series of a capture, each `<role>/<quantity>/<series>`.
pub fn draw(recording: &RecordingStream, capture: &CaptureRows) -> anyhow::Result<()> {
    let rows = parted(&capture.rows);
    for (quantity, name, color, of) in SERIES {
        let entity = format!("{}/{quantity}/{name}", capture.role);
        recording.log_static(entity.as_str(), &line(name, color, 1.2))?;
        let times = TimeColumn::new_duration_secs(TIMELINE, rows.iter().map(|(t_s, _)| *t_s));
        let values = Scalars::new(rows.iter().map(|(_, row)| row.as_ref().map_or(f64::NAN, of)));
        recording.send_columns(entity.as_str(), [times], values.columns_of_unit_batches()?)?;
    }
    Ok(())
}

/// The rows by their time, with nothing in between where some are left out: a line must not bridge a rest.
fn parted(rows: &[Row]) -> Vec<(f64, Option<Row>)> {
    let mut steps: Vec<f64> = rows.windows(2).map(|pair| pair[1].t_s - pair[0].t_s).collect();
    steps.sort_by(f64::total_cmp);
    let usual_s = steps.get(steps.len() / 2).copied().unwrap_or(f64::INFINITY);
    let mut parted: Vec<(f64, Option<Row>)> = Vec::with_capacity(rows.len());
    for row in rows {
        if let Some((before_s, _)) = parted.last()
            && row.t_s - before_s > GAP * usual_s
        {
            parted.push((before_s + usual_s, None));
        }
        parted.push((row.t_s, Some(*row)));
    }
    parted
}

#[cfg(test)]
mod tests {
    use super::{Row, parted};

    #[test]
    fn a_line_does_not_bridge_a_rest() {
        let row = |t_s| Row { t_s, ..Row::default() };
        let rows = [0.0, 0.1, 0.2, 1.5, 1.6, 1.7].map(row);
        let missing: Vec<bool> = parted(&rows).iter().map(|(_, row)| row.is_none()).collect();
        assert_eq!(missing, [false, false, false, true, false, false, false]);
        assert!(parted(&[]).is_empty());
    }
}
