//! Names, colours and widths of the time series.

use dynamics::Axis;
use rerun::components::{AggregationPolicy, MarkerShape};
use rerun::datatypes::Rgba32;
use rerun::{RecordingStream, RecordingStreamResult, SeriesLines, SeriesPoints};
use shared_types::ProcessKind;

use crate::entities::{self, HEALTH, MODEL_TORQUE, SIGNALS, parameters};
use crate::palette::{MEASURED, MODEL, NEGATIVE, POSITIVE, translucent};

/// One line, whose extremes are seen however far one zooms out.
pub fn line(name: &str, color: Rgba32, width: f32) -> SeriesLines {
    SeriesLines::new()
        .with_names([name])
        .with_colors([color])
        .with_widths([width])
        .with_aggregation_policy(AggregationPolicy::MinMax)
}

/// Names, colours and widths of the series, drawn once per recording.
pub fn draw(recording: &RecordingStream, axis: Axis) -> RecordingStreamResult<()> {
    for field in SIGNALS.into_iter().filter(|field| *field != MODEL_TORQUE) {
        recording
            .log_static(axis.words(&entities::signal(field)).as_ref(), &line(&axis.words(field), MEASURED, 1.2))?;
    }
    // rerun draws points over lines, so that the model's dots stay visible over the measured line. At this size a square looks like a
    // circle and has a fifteenth of its triangles.
    let dots = SeriesPoints::new()
        .with_names([axis.words(MODEL_TORQUE).as_ref()])
        .with_colors([MODEL])
        .with_markers([MarkerShape::Square])
        .with_marker_sizes([1.2]);
    recording.log_static(axis.words(&entities::signal(MODEL_TORQUE)).as_ref(), &dots)?;
    for name in parameters().map(|parameter| parameter.name) {
        let color = match name {
            name if name.ends_with("negative") => NEGATIVE,
            name if name.ends_with("positive") => POSITIVE,
            _ => MEASURED,
        };
        let [value, end] = [color, translucent(color, 200)];
        let lines = line(name, color, 2.4)
            .with_names([name.to_owned(), format!("{name} ci95_low"), format!("{name} ci95_high")])
            .with_colors([value, end, end])
            .with_widths([2.4, 1.3, 1.3]);
        recording.log_static(entities::parameter(name), &lines)?;
    }
    recording.log_static(entities::LATENESS, &line("largest lateness", MEASURED, 1.5))?;
    recording.log_static(entities::TICK_PERIOD, &line("tick period", MODEL, 1.5))?;
    let processes =
        [(ProcessKind::Recorder, POSITIVE), (ProcessKind::LiveFitter, MODEL), (ProcessKind::Viewer, MEASURED)];
    for quantity in HEALTH {
        for (process, color) in processes {
            let name = process.name();
            recording.log_static(entities::health(quantity, name), &line(name, color, 1.8))?;
        }
    }
    Ok(())
}
