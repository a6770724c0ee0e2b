//! A forest plot for each parameter: every capture's interval, one below the other, and the mean's.

use identification::{Estimated, Repeatability};
use maud::{Markup, html};

use crate::AveragePage;
use crate::parameter_table::true_value;
use crate::plot::{Axis, short};

/// Width of a plot, its room for row labels and its right margin, SVG units.
const WIDTH: f64 = 280.0;
const LEFT: f64 = 40.0;
const RIGHT: f64 = 16.0;
/// Height of a row and of the tick labels, SVG units.
const ROW: f64 = 20.0;
const BOTTOM: f64 = 24.0;
/// Half the height of an interval's ends and of the mean's diamond, SVG units.
const END: f64 = 4.0;
const DIAMOND: f64 = 5.5;
/// Round values along the axis.
const TICKS: usize = 4;
/// Largest distance of a true value from the mean at which it widens the axis, in half widths of the widest interval.
const REACH: f64 = 2.0;

/// The plots side by side with their words; `None` if no parameter was estimated twice.
pub(super) fn figure(page: &AveragePage<'_>) -> Option<Markup> {
    let estimated: Vec<(&str, &Repeatability)> = page
        .average
        .fit
        .parameters
        .0
        .iter()
        .filter_map(|parameter| Some((parameter.name, page.average.repeatability.get(parameter.name)?)))
        .collect();
    if estimated.is_empty() {
        return None;
    }
    Some(html! {
        figure.forests {
            h3 { span.number { "Figure 1 " } "Each capture's parameters and their mean" }
            div.thirds {
                @for (name, record) in &estimated {
                    div.forest {
                        p { code { (name) } " " span.axis { "(" (record.unit) ")" } }
                        (plot(name, record, truth(page, name, record)))
                    }
                }
            }
            figcaption {
                "Dots with whiskers: a capture's value and 95 % interval. Diamond and band: the mean and its interval, which \
                 narrows as captures agree and widens as they differ."
                @if page.truth.is_some() { " Dashed line: the true value of the simulated knob." }
                @if let Some(angle_rad) = estimated.iter().find_map(|(_, record)| record.at_angle_rad) {
                    " The phase is that at the captures' mean angle, " (crate::numbers::three(angle_rad)) " rad."
                }
            }
        }
    })
}

/// The true value as it compares with the captures: a phase at their mean angle.
fn truth(page: &AveragePage<'_>, name: &str, record: &Repeatability) -> Option<f64> {
    let value = true_value(page.truth, name, None)?;
    let Some(angle_rad) = record.at_angle_rad else { return Some(value) };
    let period_rad = page.truth?.parameter("detent_period")?;
    let turn = std::f64::consts::TAU;
    let phase = value + angle_rad / period_rad;
    Some(phase + turn * ((record.mean.value - phase) / turn).round())
}

fn plot(name: &str, record: &Repeatability, truth: Option<f64>) -> Markup {
    let rows = record.compared.len() + 1;
    let bottom = place(rows) - 0.5 * ROW;
    let height = bottom + BOTTOM;
    let ends = |estimate: &Estimated| [estimate.value - estimate.half_width, estimate.value + estimate.half_width];
    let widest =
        record.compared.iter().flatten().map(|estimate| estimate.half_width).fold(record.mean.half_width, f64::max);
    let near = truth.filter(|truth| (truth - record.mean.value).abs() <= REACH * widest);
    let estimates = record.compared.iter().flatten().chain([&record.mean]);
    let axis = Axis::around("", estimates.flat_map(ends).chain(near));
    let x = |value: f64| short(LEFT + axis.share(value) * (WIDTH - LEFT - RIGHT));
    let [low, high] = ends(&record.mean);
    let mean_row = place(rows - 1);
    html! {
        svg.plot xmlns="http://www.w3.org/2000/svg" viewBox={"0 0 " (WIDTH) " " (height)} role="img"
            aria-label={"Values of " (name) ", capture by capture"} {
            path.area.model d={"M" (x(low)) " 0H" (x(high)) "V" (bottom) "H" (x(low)) "Z"} {}
            @for (at, label) in axis.ticks(TICKS) {
                path.line.grid d={"M" (x(at)) " 0V" (bottom)} {}
                text.label x=(x(at)) y=(bottom) dy="1.3em" text-anchor="middle" { (label) }
            }
            @if let Some(truth) = near { path.line.reference d={"M" (x(truth)) " 0V" (bottom)} {} }
            @for (index, estimate) in record.compared.iter().enumerate() {
                text.label x=(LEFT - 10.0) y=(place(index)) dy="0.35em" text-anchor="end" { (index + 1) }
                @if let Some(estimate) = estimate { (whisker(&x, ends(estimate), estimate.value, place(index))) }
            }
            text.title x=(LEFT - 10.0) y=(mean_row) dy="0.35em" text-anchor="end" { "mean" }
            path.line.model d={"M" (x(low)) " " (mean_row) "H" (x(high))} {}
            path.diamond.model d={
                "M" (x(record.mean.value)) " " (mean_row - DIAMOND) "l" (DIAMOND) " " (DIAMOND) "l" (-DIAMOND) " " (DIAMOND)
                "l" (-DIAMOND) " " (-DIAMOND) "Z"
            } {}
        }
    }
}

fn whisker(x: &impl Fn(f64) -> String, [low, high]: [f64; 2], value: f64, y: f64) -> Markup {
    html! {
        path.line.label d={
            "M" (x(low)) " " (y) "H" (x(high)) "M" (x(low)) " " (y - END) "v" (2.0 * END) "M" (x(high)) " " (y - END) "v" (2.0 * END)
        } {}
        circle.point cx=(x(value)) cy=(y) r="3.2" {}
    }
}

/// Middle of a row, SVG units.
fn place(row: usize) -> f64 {
    (row as f64 + 0.5) * ROW
}
