//! Draws an x-y plot in a plane: grid, frame, labels, points and curves.

use rerun::{LineStrips2D, Points2D, Radius, RecordingStream, RecordingStreamResult, Scale3D, Transform3D};

use crate::entities;
use crate::palette::{MODEL, NEGATIVE, NEUTRAL, POSITIVE};
use crate::plot_axes::{BOX_HEIGHT, BOX_WIDTH, PlotAxes};
use crate::scatter::{Abscissa, PlotUpdate};

/// Draws plots and remembers which axes they have: axes are drawn again only when they change.
#[derive(Debug, Default)]
pub struct PlotPen {
    drawn: Vec<(Abscissa, PlotAxes)>,
}

impl PlotPen {
    /// Draws what is new in a plot at the recording's current time.
    ///
    /// # Errors
    /// When rerun refuses a part of it.
    pub fn draw(&mut self, recording: &RecordingStream, plot: &PlotUpdate) -> RecordingStreamResult<()> {
        let root = entities::plot(plot.abscissa);
        let now = (plot.abscissa, plot.axes.clone());
        if !self.drawn.contains(&now) {
            draw_axes(recording, &root, plot.abscissa, &plot.axes)?;
            self.drawn.retain(|(abscissa, _)| *abscissa != plot.abscissa);
            self.drawn.push(now);
        }
        if !plot.points.is_empty() {
            draw_points(recording, &root, plot)?;
        }
        plot.curves.as_ref().map_or(Ok(()), |curves| draw_curves(recording, &root, curves))
    }
}

fn draw_points(recording: &RecordingStream, root: &str, plot: &PlotUpdate) -> RecordingStreamResult<()> {
    let color = |turning_positive| if turning_positive { POSITIVE } else { NEGATIVE }.opaque();
    recording.log(
        format!("{root}/quantities/measured"),
        &Points2D::new(plot.points.iter().map(|point| [single(point.x), single(point.torque_mnm)]))
            .with_colors(plot.points.iter().map(|point| color(point.turning_positive)))
            .with_radii([Radius::new_ui_points(1.3)])
            .with_draw_order(10.0),
    )
}

fn draw_curves(recording: &RecordingStream, root: &str, curves: &[Vec<[f64; 2]>]) -> RecordingStreamResult<()> {
    let strips = curves.iter().map(|curve| curve.iter().map(|point| point.map(single)).collect::<Vec<_>>());
    recording.log(
        format!("{root}/quantities/model"),
        &LineStrips2D::new(strips)
            .with_colors([MODEL.opaque()])
            .with_radii([Radius::new_ui_points(1.1)])
            .with_draw_order(20.0),
    )
}

fn draw_axes(
    recording: &RecordingStream,
    root: &str,
    abscissa: Abscissa,
    axes: &PlotAxes,
) -> RecordingStreamResult<()> {
    let (x_ticks, y_ticks) = (axes.x.ticks(), axes.y.ticks());
    let (width, height) = (single(BOX_WIDTH), single(BOX_HEIGHT));
    let x_at = |value: f64| single(axes.place(value, axes.y.low)[0]);
    let y_at = |value: f64| single(axes.place(axes.x.low, value)[1]);

    let verticals = x_ticks.iter().map(|(value, _)| vec![[x_at(*value), 0.0], [x_at(*value), height]]);
    let horizontals = y_ticks.iter().map(|(value, _)| vec![[0.0, y_at(*value)], [width, y_at(*value)]]);
    recording.log(
        format!("{root}/grid"),
        &LineStrips2D::new(verticals.chain(horizontals).collect::<Vec<_>>())
            // Thin rather than translucent: rerun draws a translucent line black where it fills a pixel.
            .with_colors([NEUTRAL.opaque()])
            .with_radii([Radius::new_ui_points(0.3)])
            .with_draw_order(0.0),
    )?;
    recording.log(
        format!("{root}/frame"),
        &LineStrips2D::new([[[0.0, 0.0], [width, 0.0], [width, height], [0.0, height], [0.0, 0.0]]])
            .with_colors([NEUTRAL.opaque()])
            .with_radii([Radius::new_ui_points(0.7)])
            .with_draw_order(1.0),
    )?;

    let x_labels = x_ticks.into_iter().map(|(value, label)| ([x_at(value), height * 1.005], label));
    let y_labels = y_ticks.into_iter().map(|(value, label)| ([-0.055 * width, y_at(value) - 0.045 * height], label));
    let titles = [
        ([width / 2.0, height * 1.085], abscissa.name().to_owned()),
        ([0.0, -0.095 * height], "torque_mnm".to_owned()),
    ];
    let (places, labels): (Vec<[f32; 2]>, Vec<String>) = x_labels.chain(y_labels).chain(titles).unzip();
    recording.log(
        format!("{root}/labels"),
        &Points2D::new(places)
            .with_labels(labels)
            .with_show_labels(true)
            .with_colors([NEUTRAL.opaque()])
            .with_radii([Radius::new_ui_points(0.0)]),
    )?;

    // Points stay in their own quantities: when the axes change, only this transform does.
    let ([scale_x, scale_y], [offset_x, offset_y]) = (axes.scale(), axes.offset());
    recording.log(
        format!("{root}/quantities"),
        &Transform3D::from_translation_scale(
            [single(offset_x), single(offset_y), 0.0],
            Scale3D::from([single(scale_x), single(scale_y), 1.0]),
        ),
    )
}

/// rerun draws in single precision.
#[allow(clippy::cast_possible_truncation, reason = "the screen has fewer digits than an f32")]
fn single(value: f64) -> f32 {
    value as f32
}
