//! Names, colours and widths of the time series.

use dynamics::Axis;
use rerun::components::{AggregationPolicy, MarkerShape};
use rerun::{RecordingStream, RecordingStreamResult, SeriesLines, SeriesPoints};
use shared_types::ProcessKind;

use crate::entities::{self, HEALTH, MODEL_TORQUE, PARAMETERS, SIGNALS};
use crate::palette::{MEASURED, MODEL, NEGATIVE, POSITIVE, Rgb};

/// Names, colours and widths of the series, drawn once per recording.
///
/// # Errors
/// When rerun refuses the entity.
pub fn draw(recording: &RecordingStream, axis: Axis) -> RecordingStreamResult<()> {
    let lines = |names: Vec<String>, color: Rgb, widths: Vec<f32>| {
        let dimmed = |index: usize| {
            if index == 0 { color.opaque() } else { color.translucent(200) }
        };
        SeriesLines::new()
            .with_colors((0..names.len()).map(dimmed))
            .with_names(names)
            .with_widths(widths)
            .with_aggregation_policy(AggregationPolicy::MinMax)
    };
    for field in SIGNALS.into_iter().filter(|field| *field != MODEL_TORQUE) {
        let name = axis.words(field).into_owned();
        recording.log_static(axis.words(&entities::signal(field)).as_ref(), &lines(vec![name], MEASURED, vec![1.2]))?;
    }
    // rerun draws points over lines: as dots the model is seen over what was measured. At this size a square
    // looks like a circle and has a fifteenth of its triangles.
    recording.log_static(
        axis.words(&entities::signal(MODEL_TORQUE)).as_ref(),
        &SeriesPoints::new()
            .with_names([axis.words(MODEL_TORQUE).into_owned()])
            .with_colors([MODEL.opaque()])
            .with_markers([MarkerShape::Square])
            .with_marker_sizes([1.2]),
    )?;
    for (name, _) in PARAMETERS {
        let color = match name {
            name if name.ends_with("negative") => NEGATIVE,
            name if name.ends_with("positive") => POSITIVE,
            _ => MEASURED,
        };
        let names = vec![name.to_owned(), format!("{name} ci95_low"), format!("{name} ci95_high")];
        recording.log_static(entities::parameter(name), &lines(names, color, vec![2.4, 1.3, 1.3]))?;
    }
    let lateness = lines(vec!["largest lateness".to_owned()], MEASURED, vec![1.5]);
    recording.log_static(entities::LATENESS, &lateness)?;
    recording.log_static(entities::TICK_PERIOD, &lines(vec!["tick period".to_owned()], MODEL, vec![1.5]))?;
    let processes =
        [(ProcessKind::Recorder, POSITIVE), (ProcessKind::LiveFitter, MODEL), (ProcessKind::Viewer, MEASURED)];
    for quantity in HEALTH {
        for (process, color) in processes {
            let name = process.name();
            recording.log_static(entities::health(quantity, name), &lines(vec![name.to_owned()], color, vec![1.8]))?;
        }
    }
    Ok(())
}
