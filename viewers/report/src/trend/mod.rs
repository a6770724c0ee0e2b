//! The page of a trend: each parameter over time, by group.

mod input;

use identification::statistics::range;
use maud::{Markup, html};

pub use input::{Drift, Trend, TrendGroup, TrendParameter, TrendPoint};

use crate::figures::{Figure, Mark, THIRD};
use crate::numbers::{Digits, count};
use crate::page::{document, footer};
use crate::parameter_table::name_cells;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Most groups that are drawn side by side; the table has all.
const MOST_DRAWN: usize = 6;
/// Half the width of a capture's interval in a plot, and its least half height, as shares of the axes: it is seen however small.
const BAR: f64 = 0.006;

pub(crate) fn trend_page(trend: &Trend) -> Markup {
    let drawn = &trend.groups[..trend.groups.len().min(MOST_DRAWN)];
    let names: Vec<&str> = parameters(trend);
    let mut number = 0;
    let content = html! {
        header {
            p.kind { "Captures over time" }
            h1 { (trend.source) }
            p.verdict { (verdict(trend)) }
        }
        section {
            h2 { "Parameters" }
            (table(trend, &names))
        }
        @if trend.groups.iter().any(|group| !group.verdicts.is_empty()) {
            section {
                h2 { "Verdicts" }
                @for group in &trend.groups { p { (group.name) ": " (group.verdicts_in_words()) } }
            }
        }
        section {
            h2 { "Over time" }
            @if drawn.len() < trend.groups.len() {
                p { "Of " (trend.groups.len()) " groups the first " (drawn.len()) " are drawn." }
            }
            @for name in &names {
                div.thirds {
                    @for figure in figures(drawn, name) { (figure.numbered({ number += 1; number })) }
                }
            }
        }
        section {
            h2 { "How the numbers were made" }
            p {
                "Every capture counts alike. The drift is the straight line of least squares through them, its interval from their \
                 scatter about it; it is significant where the interval excludes zero, as one in twenty does by chance."
            }
        }
        (footer(&trend.software_version, &trend.source))
    };
    document(&trend.source, &content)
}

/// Names of the parameters that any group has, in the table's order.
fn parameters(trend: &Trend) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for parameter in trend.groups.iter().flat_map(|group| &group.parameters) {
        if !names.contains(&parameter.name.as_str()) {
            names.push(&parameter.name);
        }
    }
    names
}

fn verdict(trend: &Trend) -> String {
    let all = || trend.groups.iter().flat_map(|group| group.parameters.iter().map(move |one| (group, one)));
    let drifts = || all().filter_map(|(group, one)| Some((group, one, one.drift?)));
    let significant: Vec<String> = drifts()
        .filter(|(_, _, drift)| drift.is_significant())
        .map(|(group, one, _)| format!("{} of {}", one.name, group.name))
        .collect();
    let captures: usize =
        trend.groups.iter().filter_map(|group| group.parameters.iter().map(|one| one.captures).max()).sum();
    let left_out: String = [(trend.with_error, "with an error"), (trend.without_time, "whose time is not known")]
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, which)| format!(" {count} {which} are left out."))
        .collect();
    let drift = match (significant.len(), drifts().count()) {
        (0, 0) => "No group has captures at three times or more, so no drift can be estimated.".to_owned(),
        (0, of) => format!("None of {of} parameters drifts."),
        (some, of) => format!("{some} of {of} parameters drift: {}.", significant.join(", ")),
    };
    format!("{} captures by {}. {drift}{left_out}", count(captures as u64), trend.by)
}

fn table(trend: &Trend, names: &[&str]) -> Markup {
    html! {
        div.scroll {
            table.parameters.compared {
                thead {
                    tr {
                        th { "parameter" }
                        th { "symbol" }
                        th { (trend.by) }
                        th.number { "captures" }
                        th.number { "mean" }
                        th.number { "from capture to capture" span.faint { "standard deviation" } }
                        th.number { "their own 95 %" span.faint { "mean half width" } }
                        th.number { "drift a day" span.faint { "95 % interval" } }
                        th { "unit" }
                    }
                }
                tbody {
                    @for name in names {
                        @for (group, one) in of_name(&trend.groups, name) { (row(group, one)) }
                    }
                }
            }
        }
    }
}

fn of_name<'a>(groups: &'a [TrendGroup], name: &'a str) -> impl Iterator<Item = (&'a TrendGroup, &'a TrendParameter)> {
    groups
        .iter()
        .flat_map(move |group| group.parameters.iter().filter(move |one| one.name == name).map(move |one| (group, one)))
}

fn row(group: &TrendGroup, one: &TrendParameter) -> Markup {
    let width = one.sd.unwrap_or(0.0).max(one.mean_ci95_half_width.unwrap_or(0.0));
    let two =
        |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |value| Digits::significant(value, 2).show(value));
    html! {
        tr {
            (name_cells(&one.name))
            td { (group.name) }
            td.number { (one.captures) }
            td.number.value { (Digits::of_interval(one.mean, width).show(one.mean)) }
            td.number { (two(one.sd)) }
            td.number { (two(one.mean_ci95_half_width)) }
            @match one.drift {
                Some(drift) => {
                    @let [low, high] = drift.per_day_ci95;
                    @let digits = Digits::of_interval(drift.per_day, 0.5 * (high - low));
                    td.number { (digits.show(drift.per_day)) span.faint { (digits.span([low, high])) } }
                },
                None => td.number { "–" },
            }
            td { (one.unit) }
        }
    }
}

/// A parameter's captures, group by group on the same axes.
fn figures(groups: &[TrendGroup], name: &str) -> Vec<Figure> {
    let points = || of_name(groups, name).flat_map(|(_, one)| &one.points);
    let days = points().map(|point| point.days).fold(0.0, f64::max);
    let [lowest, highest] = range(points().flat_map(|point| point.ci95.unwrap_or([point.value; 2])));
    let bar = BAR * days.max(f64::MIN_POSITIVE);
    let least = 2.0 * BAR * (highest - lowest);
    let draw = |(group, one): (&TrendGroup, &TrendParameter)| {
        let interval = |point: &TrendPoint| {
            let [low, high] = point.ci95.unwrap_or([point.value; 2]);
            let (low, high) = (low.min(point.value - least), high.max(point.value + least));
            Layer::Band(Ink::Measured, vec![(point.days - bar, low, high), (point.days + bar, low, high)])
        };
        let mut layers: Vec<Layer> = one.points.iter().map(interval).collect();
        let mut legend = vec![(Mark::Band, Ink::Measured, "captures, 95 %")];
        if one.drift.is_some() {
            layers.push(Layer::Line(Ink::Model, line(one).collect()));
            legend.push((Mark::Line, Ink::Model, "drift"));
        }
        let lines = of_name(groups, name).flat_map(|(_, one)| line(one)).map(|(_, value)| value);
        let plot = Plot {
            size: THIRD,
            x: Axis::around("days", [-2.0 * bar, days + 2.0 * bar]),
            y: Axis::around(&format!("{name} ({})", one.unit), [lowest, highest].into_iter().chain(lines)),
            layers,
        };
        Figure {
            title: format!("{name}, {}", group.name),
            legend,
            plot: plot.svg(&format!("{name} over time, {}", group.name)),
            caption: String::new(),
        }
    };
    of_name(groups, name).map(draw).collect()
}

/// The drift from a parameter's first capture to its last, as days and values; nothing without one.
fn line(one: &TrendParameter) -> impl Iterator<Item = (f64, f64)> {
    let ends = one.drift.map(|drift| {
        let at = |point: &TrendPoint| (point.days, drift.at_start + drift.per_day * point.days);
        one.points.first().map(at).into_iter().chain(one.points.last().map(at))
    });
    ends.into_iter().flatten()
}
