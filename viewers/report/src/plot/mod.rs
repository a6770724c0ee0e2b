//! A plot: axes and layers, drawn by plotters into themed SVG.

pub(crate) mod ink;
pub(crate) mod themed_svg;

use identification::statistics::range;
use maud::{Markup, PreEscaped, html};
use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged as _;
use plotters::coord::types::RangedCoordf64;
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{
    Cartesian2d, ChartBuilder, ChartContext, Circle, DrawingArea, IntoDrawingArea as _, LabelAreaPosition, PathElement,
    Polygon, Rectangle, Text,
};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, IntoFont as _, TRANSPARENT, TextStyle};
use std::convert::Infallible;

use self::ink::Ink;
use self::themed_svg::{PIXELS_PER_UNIT, ThemedSvg};
use crate::numbers::fixed;

/// Margin beyond the outermost points, as a share of their distance.
const MARGIN: f64 = 0.04;
/// Shortest axis, in its unit and as a share of its values.
const NARROWEST: f64 = 1e-8;
/// Room for the tick labels of the y axis, SVG units.
const LEFT: u32 = 46;
/// Room for the tick labels and the title of the x axis, SVG units.
const BOTTOM: u32 = 46;
/// Room for the title of the y axis, which stands above it, SVG units.
const TOP: u32 = 26;
/// Room for half a tick label beyond the axis, SVG units.
const RIGHT: u32 = 12;
/// From the plot to its tick labels, SVG units.
const LABEL_GAP: u32 = 7;
/// Size of letters, SVG units; the style sheet has the same.
const LETTERS: u32 = 12;
/// SVG units from one tick label to the next, at least, along x and along y.
const TICK_DISTANCE: (u32, u32) = (52, 30);
/// Fewest and most tick labels of an axis.
const TICKS: (u32, u32) = (3, 11);

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct Axis {
    title: String,
    low: f64,
    high: f64,
}

impl Axis {
    /// An axis that holds all finite `values` with a margin.
    pub(crate) fn around(title: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let [low, high] = range(values.into_iter().filter(|value| value.is_finite()));
        let (low, high) = if low <= high { (low, high) } else { (0.0, 1.0) };
        let margin = if high > low { MARGIN * (high - low) } else { (0.1 * high.abs()).max(1.0) };
        Self::exactly(title, low - margin, high + margin)
    }

    /// An axis from `low` to `high`, or about their middle where they hardly differ.
    pub(crate) fn exactly(title: &str, low: f64, high: f64) -> Self {
        let title = title.to_owned();
        // plotters does not end its search for ticks in a range that is empty or not finite.
        if !(low.is_finite() && high.is_finite()) {
            return Self { title, low: 0.0, high: 1.0 };
        }
        let least = NARROWEST.max(NARROWEST * low.abs().max(high.abs()));
        let widen = if high - low < least { least } else { 0.0 };
        Self { title, low: low - widen, high: high + widen }
    }

    /// Place of a value along the axis, from 0 to 1 where it lies on it.
    pub(crate) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// At most about so many round values with what to write at them.
    pub(crate) fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let decimals = self.decimals(most);
        let ticks = RangedCoordf64::from(self.low..self.high).key_points(most);
        ticks.into_iter().map(|tick| (tick, fixed(tick, decimals))).collect()
    }

    fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Number of ticks to ask plotters for, which may give far fewer than asked.
    fn labels(&self, room: u32, distance: u32) -> usize {
        let wanted = (room / distance).clamp(TICKS.0, TICKS.1) as usize;
        let given = |asked: &usize| RangedCoordf64::from(self.low..self.high).key_points(*asked).len();
        (wanted..=2 * wanted).find(|asked| 2 * given(asked) > wanted).unwrap_or(wanted)
    }

    /// Decimals with which every tick is exact.
    fn decimals(&self, labels: usize) -> usize {
        let ticks = RangedCoordf64::from(self.low..self.high).key_points(labels);
        let step = ticks.windows(2).map(|pair| pair[1] - pair[0]).fold(self.high - self.low, f64::min);
        (0..9)
            .find(|decimals: &i32| {
                let scale = 10_f64.powi(*decimals);
                ticks.iter().all(|tick| ((tick * scale).round() / scale - tick).abs() < 1e-3 * step)
            })
            .map_or(9, |decimals| decimals.unsigned_abs() as usize)
    }
}

/// Marks of one kind.
#[derive(Clone, Debug)]
pub(crate) enum Layer {
    /// Translucent dots; clouds are drawn in turns, so that none hides another.
    Clouds(Vec<(Ink, Vec<(f64, f64)>)>),
    /// A line through points.
    Line(Ink, Vec<(f64, f64)>),
    /// The area between a lower and an upper value at each x.
    Band(Ink, Vec<(f64, f64, f64)>),
    /// Bars from zero: left, right, height.
    Bars(Ink, Vec<(f64, f64, f64)>),
    /// A level across the plot.
    Level(Ink, f64),
    /// A place along x, with a word on it.
    Place(Ink, f64, String),
}

/// Rounds in which clouds take turns.
const TURNS: usize = 12;

/// A plot of given size in SVG units.
#[derive(Clone, Debug)]
pub(crate) struct Plot {
    pub(crate) size: (u32, u32),
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) layers: Vec<Layer>,
}

type Area<'a> = DrawingArea<ThemedSvg<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, ThemedSvg<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Failure = DrawingAreaErrorKind<Infallible>;

impl Plot {
    /// The plot as an `svg` element that reads itself out as `description`.
    pub(crate) fn svg(&self, description: &str) -> Markup {
        let (width, height) = self.size;
        let mut marks = String::new();
        let pixels = (width * PIXELS_PER_UNIT, height * PIXELS_PER_UNIT);
        let drawn = self.draw(&ThemedSvg::new(&mut marks, pixels).into_drawing_area());
        html! {
            @match drawn {
                Ok(()) => svg.plot xmlns="http://www.w3.org/2000/svg" viewBox={"0 0 " (width) " " (height)}
                    role="img" aria-label=(description) { (PreEscaped(marks)) },
                Err(failure) => p { "This plot could not be drawn: " (failure) "." },
            }
        }
    }

    fn draw(&self, area: &Area<'_>) -> Result<(), Failure> {
        let Self { size, x, y, layers } = self;
        let letters = f64::from(LETTERS * PIXELS_PER_UNIT);
        let text = |ink: Ink| TextStyle {
            color: ink.color().to_backend_color(),
            ..TextStyle::from(("sans-serif", letters).into_font())
        };
        let mut chart = ChartBuilder::on(area)
            .margin_top(TOP * PIXELS_PER_UNIT)
            .margin_right(RIGHT * PIXELS_PER_UNIT)
            .set_left_and_bottom_label_area_size(LEFT * PIXELS_PER_UNIT)
            .x_label_area_size(BOTTOM * PIXELS_PER_UNIT)
            .build_cartesian_2d(x.low..x.high, y.low..y.high)?;
        let x_labels = x.labels(size.0 - LEFT - RIGHT, TICK_DISTANCE.0);
        let y_labels = y.labels(size.1 - TOP - BOTTOM, TICK_DISTANCE.1);
        let (x_decimals, y_decimals) = (x.decimals(x_labels), y.decimals(y_labels));
        chart
            .configure_mesh()
            .axis_style(TRANSPARENT)
            // Without axes to carry them the marks are unseen; labels stand twice their size away.
            .set_tick_mark_size(LabelAreaPosition::Bottom, (LABEL_GAP * PIXELS_PER_UNIT).div_euclid(2))
            .set_tick_mark_size(LabelAreaPosition::Left, (LABEL_GAP * PIXELS_PER_UNIT).div_euclid(2))
            .light_line_style(TRANSPARENT)
            .bold_line_style(Ink::Grid.color())
            .label_style(text(Ink::Label))
            .axis_desc_style(text(Ink::Title))
            .x_labels(x_labels)
            .y_labels(y_labels)
            .x_desc(x.title.as_str())
            .x_label_formatter(&|value| fixed(*value, x_decimals))
            .y_label_formatter(&|value| fixed(*value, y_decimals))
            .draw()?;
        let above = text(Ink::Title).pos(Pos::new(HPos::Left, VPos::Top));
        area.draw_text(&y.title, &above, (0, 0))?;
        for layer in layers {
            self.draw_layer(&mut chart, layer, &text(Ink::Label))?;
        }
        area.present()
    }

    fn draw_layer(&self, chart: &mut Chart<'_, '_>, layer: &Layer, text: &TextStyle<'_>) -> Result<(), Failure> {
        let Self { x, y, .. } = self;
        let inside = |point: &&(f64, f64)| x.contains(point.0) && y.contains(point.1);
        let height = |value: f64| value.clamp(y.low, y.high);
        match layer {
            Layer::Clouds(clouds) => {
                for turn in 0..TURNS {
                    for (ink, points) in clouds {
                        let some = points.iter().skip(turn).step_by(TURNS).filter(inside);
                        chart.draw_series(some.map(|point| Circle::new(*point, 1, ink.color().filled())))?;
                    }
                }
            }
            Layer::Line(ink, points) => {
                let points: Vec<_> = points.iter().filter(inside).copied().collect();
                chart.draw_series((points.len() > 1).then(|| PathElement::new(points, ink.color())))?;
            }
            Layer::Band(ink, edges) => {
                let edges: Vec<_> = edges.iter().filter(|(at, ..)| x.contains(*at)).collect();
                let lower = edges.iter().map(|(at, low, _)| (*at, height(*low)));
                let upper = edges.iter().rev().map(|(at, _, high)| (*at, height(*high)));
                let corners: Vec<_> = lower.chain(upper).filter(|(_, level)| level.is_finite()).collect();
                chart.draw_series((corners.len() > 3).then(|| Polygon::new(corners, ink.color())))?;
            }
            Layer::Bars(ink, bars) => {
                let bars = bars.iter().filter(|(left, right, _)| x.contains(*left) && x.contains(*right));
                chart.draw_series(bars.map(|(left, right, level)| {
                    Rectangle::new([(*left, height(0.0)), (*right, height(*level))], ink.color().filled())
                }))?;
            }
            Layer::Level(ink, level) => {
                let line = vec![(x.low, *level), (x.high, *level)];
                chart.draw_series(y.contains(*level).then(|| PathElement::new(line, ink.color())))?;
            }
            Layer::Place(ink, at, word) => {
                if x.contains(*at) {
                    chart.draw_series([PathElement::new(vec![(*at, y.low), (*at, y.high)], ink.color())])?;
                    let style = text.pos(Pos::new(HPos::Center, VPos::Bottom));
                    chart.draw_series([Text::new(word.clone(), (*at, y.high), style)])?;
                }
            }
        }
        Ok(())
    }
}

/// A length in SVG units, to the tenth.
pub(crate) fn short(units: f64) -> String {
    format!("{units:.1}")
}
