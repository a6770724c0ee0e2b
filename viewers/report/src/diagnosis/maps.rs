//! The residual as a map over everything that it might depend on.

use identification::diagnosis::Location;
use maud::{Markup, html};

use super::Numbering;
use super::shape::shape;
use crate::figures::{HALF, THIRD, WIDE};
use crate::numbers::two;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// Probabilities below this are shown as smaller.
const SMALLEST_PROBABILITY: f64 = 1e-6;
/// Maps that are shown where none is significant.
const SHOWN_ANYWAY: usize = 3;
/// Title of the y axis.
const MEAN_RESIDUAL: &str = "mean residual (mNm)";

/// The maps of the first model's residual, with what each explains.
pub(super) fn section(locations: &[Location], numbers: &mut Numbering) -> Markup {
    if locations.is_empty() {
        return html! { p { "The residual was not mapped." } };
    }
    let significant = locations.iter().filter(|location| location.significant).count();
    html! {
        p.lead {
            "Before anything is named: the mean of what the first model leaves of the training capture, against each quantity that \
             it might depend on. "
            @match significant {
                0 => "No quantity alone explains more than chance would. That is so when nothing is missing, and when what is \
                      missing depends on several quantities at once or averages out over each.",
                1 => "One quantity explains more than chance would.",
                _ => { "Of them " (significant) " explain more than chance would." },
            }
        }
        (maps(locations, Ink::Before, "Where the gap is", numbers))
        (table(locations))
    }
}

/// The maps worth showing: the significant ones, or the first few if there are none.
fn shown(locations: &[Location]) -> Vec<&Location> {
    let drawn = || locations.iter().filter(|location| !location.map.is_empty());
    let significant: Vec<&Location> = drawn().filter(|location| location.significant).collect();
    if significant.is_empty() {
        drawn().filter(|location| location.explained_percent > 0.0).take(SHOWN_ANYWAY).collect()
    } else {
        significant
    }
}

/// The maps worth showing, all on one scale.
pub(super) fn maps(locations: &[Location], ink: Ink, title: &str, numbers: &mut Numbering) -> Markup {
    let shown = shown(locations);
    let panels =
        shown.iter().map(|location| Panel { location, maps: vec![(ink, &location.map)], shape: shape(location) });
    let bins = shown.iter().map(|location| location.map.len()).max().unwrap_or(0);
    let caption = html! {
        "Each dot is the mean of one in " (bins) " parts of the rows" @if shown.len() > 1 { "; all plots share one scale" } ". A level \
         line at zero is no dependence. A slope, a wave, a step or a bend says on what, and how, the missing torque depends."
    };
    figure(&panels.collect::<Vec<_>>(), title, &[], &caption, numbers)
}

/// The maps of the first model worth showing, and what the final model makes of them.
pub(super) fn before_and_after<'a>(before: &'a [Location], after: &'a [Location], numbers: &mut Numbering) -> Markup {
    let panel = |location: &'a Location| {
        let later = after.iter().find(|later: &&Location| later.coordinate == location.coordinate)?;
        Some(Panel { location: later, maps: vec![(Ink::Before, &location.map), (Ink::After, &later.map)], shape: None })
    };
    let panels: Vec<Panel<'_>> = shown(before).into_iter().filter_map(panel).collect();
    let caption = html! {
        "The maps from above, and the same of what the final model leaves. Where the missing torque was found, the line after lies \
         at zero. The figures above the plots are those of what is left."
    };
    let legend = [(Ink::Before, "first model"), (Ink::After, "final model")];
    figure(&panels, "Where the gap was", &legend, &caption, numbers)
}

/// One or two maps over the same coordinate.
struct Panel<'a> {
    /// The one whose share and probability are given.
    location: &'a Location,
    maps: Vec<(Ink, &'a Vec<[f64; 2]>)>,
    shape: Option<String>,
}

fn figure(
    panels: &[Panel<'_>],
    title: &str,
    legend: &[(Ink, &str)],
    caption: &Markup,
    numbers: &mut Numbering,
) -> Markup {
    let (columns, size) = match panels.len() {
        0 => return html! {},
        1 => ("whole", (WIDE.0, 240)),
        2 => ("halves", (HALF.0, 220)),
        _ => ("thirds", (THIRD.0, 200)),
    };
    let levels: Vec<f64> =
        panels.iter().flat_map(|panel| panel.maps.iter().flat_map(|(_, map)| map.iter().map(|bin| bin[1]))).collect();
    html! {
        figure.maps {
            h3 { span.number { "Figure " (numbers.next()) " " } (title) }
            @if !legend.is_empty() {
                ul.legend { @for (ink, word) in legend { li { span class={"key line " (ink.class())} {} (word) } } }
            }
            div class=(columns) {
                @for panel in panels {
                    div.map {
                        p {
                            strong { (words(panel.location.coordinate)) }
                            span.faint { (share(panel.location)) @if !panel.location.significant { " (like chance)" } }
                        }
                        (plot(panel, size, &levels))
                        @if let Some(shape) = &panel.shape { p.shape { (shape) } }
                    }
                }
            }
            figcaption { (caption) }
        }
    }
}

fn plot(panel: &Panel<'_>, size: (u32, u32), levels: &[f64]) -> Markup {
    let coordinate = words(panel.location.coordinate);
    let mut layers = vec![Layer::Level(Ink::Zero, 0.0)];
    for (ink, map) in &panel.maps {
        let points: Vec<(f64, f64)> = map
            .iter()
            .map(|[at, level]| (*at, *level))
            .filter(|(at, level)| at.is_finite() && level.is_finite())
            .collect();
        layers.extend([Layer::Line(*ink, points.clone()), Layer::Clouds(vec![(*ink, points)])]);
    }
    let places = panel.maps.iter().flat_map(|(_, map)| map.iter().map(|bin| bin[0]));
    let plot = Plot {
        size,
        x: Axis::around(&format!("{coordinate} ({})", panel.location.unit), places),
        y: Axis::around(MEAN_RESIDUAL, levels.iter().copied().chain([0.0])),
        layers,
    };
    plot.svg(&format!("Mean residual against {coordinate}"))
}

/// Every coordinate with its share and its probability.
pub(super) fn table(locations: &[Location]) -> Markup {
    html! {
        div.scroll {
            table.locations {
                thead {
                    tr {
                        th { "quantity" }
                        th.number { "explains of the mean square (%)" }
                        th.number { "p-value" }
                        th { "" }
                    }
                }
                tbody {
                    @for location in locations {
                        tr {
                            th scope="row" { (words(location.coordinate)) }
                            td.number { (two(location.explained_percent)) }
                            td.number { (probability(location.p_value)) }
                            td { @if location.significant { strong { "significant" } } @else { "like chance" } }
                        }
                    }
                }
            }
        }
    }
}

fn share(location: &Location) -> String {
    let p = probability(location.p_value);
    let relation = if p.starts_with('<') { "" } else { "= " };
    format!("explains {} %, p {relation}{p}", two(location.explained_percent))
}

/// A probability, or the bound that it is below.
pub(super) fn probability(p: f64) -> String {
    if p < SMALLEST_PROBABILITY { "< 10⁻⁶".to_owned() } else { two(p) }
}

/// A coordinate as a reader would call it.
pub(super) fn words(coordinate: &str) -> String {
    match coordinate {
        "speed-and-direction-of-acceleration" => "speed, signed by acceleration".to_owned(),
        "detent-phase" => "phase within the detent".to_owned(),
        other => other.replace('-', " "),
    }
}
