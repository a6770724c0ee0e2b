//! The figures of the page: which points they show, and what to see in them.

mod bins;
mod effects;
mod excerpt;
mod residual;
mod residual_order;
mod torque;

use std::collections::BTreeMap;

use identification::statistics::range;
use identification::{Fit, Point};
use maud::{Markup, html};

pub(crate) use effects::effect_figures;
pub(crate) use excerpt::{excerpt_figure, typical_excerpt};
pub(crate) use residual::{histogram_figure, residual_figure, residual_plot};
pub(crate) use residual_order::order_figure;
pub(crate) use torque::{
    LEGEND as TORQUE_LEGEND, angle_figure, angle_plot, quantity_plot, velocity_figure, velocity_plot,
};

use crate::plot::ink::Ink;

/// Axis titles, named like the columns `torque_mnm`, `angle_rad`, ….
pub(crate) const TORQUE: &str = "torque (mNm)";
pub(crate) const ANGLE: &str = "angle (rad)";
pub(crate) const VELOCITY: &str = "velocity (rad/s)";
const ACCELERATION: &str = "acceleration (rad/s²)";
pub(crate) const TIME: &str = "t (s)";
pub(crate) const RESIDUAL: &str = "residual (mNm)";

/// Size of a plot across the page, SVG units.
pub(crate) const WIDE: (u32, u32) = (880, 340);
/// Size of two plots side by side.
pub(crate) const HALF: (u32, u32) = (428, 260);
/// Size of three plots side by side.
pub(crate) const THIRD: (u32, u32) = (280, 250);

/// How a mark looks in the legend.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Mark {
    Dots,
    Line,
    Band,
}

impl Mark {
    fn class(self) -> &'static str {
        match self {
            Self::Dots => "dots",
            Self::Line => "line",
            Self::Band => "band",
        }
    }
}

/// The numbers in a caption, by name.
pub(crate) type Numbers = BTreeMap<&'static str, f64>;

/// A plot with its words.
pub(crate) struct Figure {
    pub(crate) title: String,
    pub(crate) legend: Vec<(Mark, Ink, &'static str)>,
    pub(crate) plot: Markup,
    pub(crate) caption: String,
}

impl Figure {
    /// The figure as the `number`th of the page; its caption refers to figure `first`, which is of the same kind.
    pub(crate) fn again(self, number: usize, first: usize) -> Markup {
        Self { caption: format!("As figure {first}, of this capture."), ..self }.numbered(number)
    }

    /// The figure as the `number`th of the page.
    pub(crate) fn numbered(&self, number: usize) -> Markup {
        html! {
            figure {
                h3 { span.number { "Figure " (number) } " " (self.title) }
                @if !self.legend.is_empty() {
                    ul.legend {
                        @for (mark, ink, word) in &self.legend {
                            li { span class={"key " (mark.class()) " " (ink.class())} {} (word) }
                        }
                    }
                }
                (self.plot)
                @if !self.caption.is_empty() { figcaption { (self.caption) } }
            }
        }
    }
}

/// Rows with nothing but finite numbers.
pub(crate) fn finite_points(fit: &Fit) -> Vec<Point> {
    let finite = |point: &&Point| {
        [
            point.t_s,
            point.angle_rad,
            point.velocity_rad_s,
            point.acceleration_rad_s2,
            point.torque_mnm,
            point.torque_model_mnm,
            point.torque_model_ci95_mnm,
            point.residual_mnm,
        ]
        .iter()
        .all(|value| value.is_finite())
    };
    fit.points.iter().filter(finite).copied().collect()
}

/// Every so many of `items`, at most about `most`.
fn thinned<T: Copy>(items: impl ExactSizeIterator<Item = T>, most: usize) -> Vec<T> {
    let step = items.len().div_ceil(most).max(1);
    items.step_by(step).collect()
}

/// Distance between the smallest and the largest angle, rad.
fn travel_rad(points: &[Point]) -> f64 {
    let [lowest, highest] = range(points.iter().map(|point| point.angle_rad));
    highest - lowest
}

/// Longest time from one row to the next that is not a gap, s.
pub(crate) fn longest_step_s<T>(rows: &[T], time_s: impl Fn(&T) -> f64) -> f64 {
    let steps = rows.windows(2).map(|pair| time_s(&pair[1]) - time_s(&pair[0])).filter(|step| *step > 0.0);
    1.5 * steps.fold(f64::INFINITY, f64::min)
}

pub(crate) fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value * value));
    if count > 0.0 { f64::sqrt(sum / count) } else { 0.0 }
}

pub(crate) fn real(count: usize) -> f64 {
    count as f64
}
