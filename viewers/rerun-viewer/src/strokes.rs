//! Lines, dots and labels of one colour, of which the drawings in space and in a plane are made.

use rerun::components::{LineStrip2D, LineStrip3D, Position2D, Position3D};
use rerun::datatypes::Rgba32;
use rerun::{LineStrips2D, LineStrips3D, Points2D, Points3D, Radius, Scale3D, Transform3D};

use crate::palette::WHITE;

/// rerun draws in single precision.
pub const fn single(value: f64) -> f32 {
    value as f32
}

/// Lines in a plane, `radius` points wide to either side.
pub fn lines_2d(strips: impl IntoIterator<Item = impl Into<LineStrip2D>>, color: Rgba32, radius: f32) -> LineStrips2D {
    LineStrips2D::new(strips).with_colors([color]).with_radii([Radius::new_ui_points(radius)])
}

/// Texts in a plane, always shown.
pub fn labels_2d(
    places: impl IntoIterator<Item = impl Into<Position2D>>,
    labels: impl IntoIterator<Item = String>,
    color: Rgba32,
) -> Points2D {
    Points2D::new(places)
        .with_labels(labels)
        .with_show_labels(true)
        .with_colors([color])
        .with_radii([Radius::new_ui_points(0.0)])
}

/// Lines in space, `radius` points wide to either side.
pub fn lines(strips: impl IntoIterator<Item = impl Into<LineStrip3D>>, color: Rgba32, radius: f32) -> LineStrips3D {
    LineStrips3D::new(strips).with_colors([color]).with_radii([Radius::new_ui_points(radius)])
}

pub fn dots(places: impl IntoIterator<Item = impl Into<Position3D>>, color: Rgba32, radius: f32) -> Points3D {
    Points3D::new(places).with_colors([color]).with_radii([Radius::new_ui_points(radius)])
}

/// Texts in space, always shown; their ground is between light and dark in either theme.
pub fn labels(
    places: impl IntoIterator<Item = impl Into<Position3D>>,
    labels: impl IntoIterator<Item = String>,
) -> Points3D {
    dots(places, WHITE, 0.0).with_labels(labels).with_show_labels(true)
}

/// Puts what lies at (x, y) in a plane to scale · (x, y) + offset.
pub fn scaled([scale_x, scale_y]: [f64; 2], [offset_x, offset_y]: [f64; 2]) -> Transform3D {
    let scale = Scale3D::from([single(scale_x), single(scale_y), 1.0]);
    Transform3D::from_translation_scale([single(offset_x), single(offset_y), 0.0], scale)
}
