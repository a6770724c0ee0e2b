//! Draws an x-y plot in a plane: grid, frame, labels, points and curves.

use std::collections::HashMap;

use dynamics::Axis;
use rerun::{Points2D, Radius, RecordingStream, RecordingStreamResult};

use crate::entities;
use crate::model_curves::ModelCurves;
use crate::palette::{MODEL, NEGATIVE, NEUTRAL, POSITIVE};
use crate::plot_axes::{BOX_HEIGHT, BOX_WIDTH, PlotAxes};
use crate::scatter::{Abscissa, PlotUpdate, ScatterPoint};
use crate::strokes::{labels_2d, lines_2d, scaled, single};

/// The axes that were drawn: they are drawn again only when they change.
/// They belong to no time: a page that is opened late has them first, and whoever looks back sees the past in them.
pub type DrawnAxes = HashMap<Abscissa, PlotAxes>;

/// Draws what is new in a plot at the recording's current time.
pub fn draw(
    recording: &RecordingStream,
    axis: Axis,
    drawn: &mut DrawnAxes,
    plot: &PlotUpdate,
) -> RecordingStreamResult<()> {
    let root = axis.words(&entities::plot(plot.abscissa)).into_owned();
    if drawn.insert(plot.abscissa, plot.axes) != Some(plot.axes) {
        let titles = [plot.abscissa.name(), "torque_mnm"].map(|name| axis.words(name).into_owned());
        draw_axes(recording, &root, titles, &plot.axes)?;
    }
    if !plot.points.is_empty() {
        let color = |point: &ScatterPoint| if point.turning_positive { POSITIVE } else { NEGATIVE };
        let points = Points2D::new(plot.points.iter().map(|point| [point.x, point.torque_mnm].map(single)))
            .with_colors(plot.points.iter().map(color))
            .with_radii([Radius::new_ui_points(1.3)])
            .with_draw_order(10.0);
        recording.log(format!("{root}/quantities/measured"), &points)?;
    }
    plot.model.as_ref().map_or(Ok(()), |model| draw_model(recording, &root, axis, model))
}

/// The model as thick lines, the ends of its interval as thin ones, and the interval in figures.
fn draw_model(recording: &RecordingStream, root: &str, axis: Axis, model: &ModelCurves) -> RecordingStreamResult<()> {
    for (name, curves, radius, order) in
        [("model", &model.curves, 1.3, 20.0), ("model_ci95", &model.borders, 0.5, 19.0)]
    {
        let strips = curves.iter().map(|curve| curve.iter().map(|point| point.map(single)).collect::<Vec<_>>());
        let lines = lines_2d(strips, MODEL, radius).with_draw_order(order);
        recording.log(format!("{root}/quantities/{name}"), &lines)?;
    }
    let label =
        model.half_width_mnm.map(|half_width| axis.words(&format!("model ± {half_width:.3} mNm (95 %)")).into_owned());
    let place = [0.82 * single(BOX_WIDTH), -0.095 * single(BOX_HEIGHT)];
    recording.log(format!("{root}/model_label"), &labels_2d([place], label, MODEL))
}

fn draw_axes(
    recording: &RecordingStream,
    root: &str,
    [abscissa, ordinate]: [String; 2],
    axes: &PlotAxes,
) -> RecordingStreamResult<()> {
    let (x_ticks, y_ticks) = (axes.x.ticks(), axes.y.ticks());
    let (width, height) = (single(BOX_WIDTH), single(BOX_HEIGHT));
    let x_at = |value: f64| single(axes.place(value, axes.y.low)[0]);
    let y_at = |value: f64| single(axes.place(axes.x.low, value)[1]);

    let verticals = x_ticks.iter().map(|(value, _)| vec![[x_at(*value), 0.0], [x_at(*value), height]]);
    let horizontals = y_ticks.iter().map(|(value, _)| vec![[0.0, y_at(*value)], [width, y_at(*value)]]);
    // Thin rather than translucent: rerun draws a translucent line black where it fills a pixel.
    let grid = lines_2d(verticals.chain(horizontals), NEUTRAL, 0.3).with_draw_order(0.0);
    recording.log_static(format!("{root}/grid"), &grid)?;
    let frame = [[[0.0, 0.0], [width, 0.0], [width, height], [0.0, height], [0.0, 0.0]]];
    recording.log_static(format!("{root}/frame"), &lines_2d(frame, NEUTRAL, 0.7).with_draw_order(1.0))?;

    let x_labels = x_ticks.into_iter().map(|(value, label)| ([x_at(value), height * 1.005], label));
    let y_labels = y_ticks.into_iter().map(|(value, label)| ([-0.055 * width, y_at(value) - 0.045 * height], label));
    let titles = [([width / 2.0, height * 1.085], abscissa), ([0.0, -0.095 * height], ordinate)];
    let (places, labels): (Vec<[f32; 2]>, Vec<String>) = x_labels.chain(y_labels).chain(titles).unzip();
    recording.log_static(format!("{root}/labels"), &labels_2d(places, labels, NEUTRAL))?;

    // Points stay in their own quantities: when the axes change, only this transform does.
    recording.log_static(format!("{root}/quantities"), &scaled(axes.scale(), axes.place(0.0, 0.0)))
}
