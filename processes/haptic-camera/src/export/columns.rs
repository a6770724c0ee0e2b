//! A capture's columns for a columnar file.

use archive::Capture;
use loaded_capture::LoadedCapture;

use super::TAKEN_ALONG;

/// The values of a column.
pub(super) enum Values<'a> {
    /// Real numbers; NaN where there is none.
    Real(&'a [f64]),
    /// Counts, below 2^63.
    Count(Vec<i64>),
    /// Codes and bits.
    Code(Vec<i32>),
}

/// A column: its name carries the unit.
pub(super) struct Column<'a> {
    /// Name, as everywhere.
    pub(super) name: &'static str,
    /// Values, one for each sample.
    pub(super) values: Values<'a>,
}

/// The columns that the capture has.
pub(super) fn of(capture: &Capture) -> Vec<Column<'_>> {
    let count = |name, values: &[u64]| {
        let values = values.iter().map(|&value| i64::try_from(value).unwrap_or(i64::MAX)).collect();
        Some(Column { name, values: Values::Count(values) })
    };
    let code = |name, values: &Option<Vec<u32>>| {
        let values = values.as_ref()?.iter().map(|&value| i32::try_from(value).unwrap_or(i32::MAX)).collect();
        Some(Column { name, values: Values::Code(values) })
    };
    [
        count("seq", &capture.seq),
        count("tick", &capture.tick),
        real("t_s", Some(&capture.t_s)),
        real("angle_rad", Some(&capture.angle_rad)),
        real("velocity_rad_s", capture.velocity_rad_s.as_ref()),
        real("acceleration_rad_s2", capture.acceleration_rad_s2.as_ref()),
        real("torque_mnm", Some(&capture.torque_mnm)),
        real("commanded_angle_rad", capture.commanded_angle_rad.as_ref()),
        real("commanded_torque_mnm", capture.commanded_torque_mnm.as_ref()),
        code("state", &capture.state),
        code("missed_ticks", &capture.missed_ticks),
        code("flags", &capture.flags),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn real<'a>(name: &'static str, values: Option<&'a Vec<f64>>) -> Option<Column<'a>> {
    values.map(|values| Column { name, values: Values::Real(values) })
}

/// What the file says of itself: the unit of every column, the rate, and what the archive had attached.
pub(super) fn metadata(loaded: &LoadedCapture, columns: &[Column<'_>]) -> Vec<(String, String)> {
    let capture = &loaded.capture;
    let units = columns.iter().filter_map(|column| {
        let unit = archive::unit_of(column.name)?;
        Some((format!("unit.{}", column.name), unit.to_owned()))
    });
    let own = [
        ("software".to_owned(), format!("haptic-camera {}", env!("CARGO_PKG_VERSION"))),
        ("source".to_owned(), capture.source.display().to_string()),
        ("rate_hz".to_owned(), capture.rate_hz.to_string()),
        ("missing_samples".to_owned(), capture.gaps.iter().map(|gap| gap.count).sum::<u64>().to_string()),
    ];
    let attached = TAKEN_ALONG.iter().filter_map(|name| {
        let text = capture.attached_text(name).filter(|text| !text.is_empty())?;
        Some(((*name).to_owned(), text.to_owned()))
    });
    own.into_iter().chain(units).chain(attached).collect()
}
