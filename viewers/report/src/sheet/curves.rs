//! Load over position, one branch a direction.

use maud::{Markup, html};
use shared_types::Axis;
use sheet::{Branch, Sheet};

use crate::figures::{Figure, Mark, WIDE};
use crate::plot::ink::Ink;
use crate::plot::{Axis as PlotAxis, Layer, Plot};

/// Detents in the plot close by.
const CLOSE: f64 = 4.0;

/// The names, words and inks of the branches.
const BRANCHES: [(&str, Ink, Ink, &str); 4] = [
    ("positive", Ink::ModelPositive, Ink::MeasuredPositive, "turning positively"),
    ("negative", Ink::ModelNegative, Ink::MeasuredNegative, "turning negatively"),
    ("press", Ink::ModelPositive, Ink::MeasuredPositive, "pressing"),
    ("return", Ink::ModelNegative, Ink::MeasuredNegative, "letting back"),
];

/// Titles of the axes.
pub(super) fn titles(axis: Axis) -> [&'static str; 2] {
    match axis {
        Axis::Rotary => ["angle (rad)", "torque (mNm)"],
        Axis::Linear => ["travel (mm)", "force (N)"],
    }
}

/// The whole curve, and a close view of some detents where there are any.
pub(super) fn figures(sheet: &Sheet) -> Markup {
    let what = if sheet.axis == Axis::Rotary { "torque over angle" } else { "force over travel" };
    let whole = figure(sheet, None, &format!("{} as measured, one branch a direction", uppercase(what)));
    let pitch = sheet.figures.get("detent_pitch").and_then(|figure| figure.value);
    let close = pitch.and_then(|pitch| {
        let middle = sheet.detents.get(sheet.detents.len() / 4)?.angle_rad;
        let range = [middle - 0.5 * pitch, middle + (CLOSE - 0.5) * pitch];
        Some(figure(sheet, Some(range), "Some detents close by"))
    });
    html! {
        (whole.numbered(1))
        @if let Some(close) = close { (close.numbered(2)) }
    }
}

fn uppercase(text: &str) -> String {
    crate::page::uppercase_first(text)
}

fn figure(sheet: &Sheet, range: Option<[f64; 2]>, title: &str) -> Figure {
    let shown = || BRANCHES.iter().filter_map(|named| Some((named, sheet.curve.get(named.0)?)));
    let points: Vec<_> = shown().map(|(named, branch)| (named, rows(branch, range))).collect();
    let [x, y] = titles(sheet.axis);
    let all = || points.iter().flat_map(|(_, rows)| rows.iter());
    let bands = points.iter().map(|((_, _, band, _), rows)| {
        Layer::Band(*band, rows.iter().map(|[at, load, half]| (*at, load - half, load + half)).collect())
    });
    let lines = points
        .iter()
        .map(|((_, line, ..), rows)| Layer::Line(*line, rows.iter().map(|[at, load, _]| (*at, *load)).collect()));
    let plot = Plot {
        size: WIDE,
        x: PlotAxis::around(x, all().map(|[at, ..]| *at)),
        y: PlotAxis::around(y, all().flat_map(|[_, load, half]| [load - half, load + half]).chain([0.0])),
        layers: [Layer::Level(Ink::Zero, 0.0)]
            .into_iter()
            .chain(bands)
            .chain(lines)
            .chain(places(sheet, range))
            .collect(),
    };
    let caption = match (sheet.axis, range) {
        (_, Some(_)) => "Turning on gets harder where a branch rises; a knob rests there. Half the distance of the branches is friction.".to_owned(),
        (Axis::Rotary, None) => "Band: 95 % interval. What lies between the branches is what a turn there and back costs.".to_owned(),
        (Axis::Linear, None) => "Band: 95 % interval. What lies between the branches is what a press and its return cost.".to_owned(),
    };
    Figure {
        title: title.to_owned(),
        legend: points.iter().map(|((_, ink, _, words), _)| (Mark::Line, *ink, *words)).collect(),
        plot: plot.svg(title),
        caption,
    }
}

/// Where a press has its features.
fn places(sheet: &Sheet, range: Option<[f64; 2]>) -> impl Iterator<Item = Layer> + use<> {
    let named = [("collapse_travel", "collapse"), ("valley_travel", "valley"), ("travel", "bottom-out")];
    let places: Vec<Layer> = named
        .into_iter()
        .filter(|_| range.is_none())
        .filter_map(|(name, word)| Some(Layer::Place(Ink::Reference, sheet.figures.get(name)?.value?, word.to_owned())))
        .collect();
    places.into_iter()
}

/// Position, load and half width within a range.
fn rows(branch: &Branch, range: Option<[f64; 2]>) -> Vec<[f64; 3]> {
    let [low, high] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    (0..branch.len())
        .map(|index| [branch.position(index), branch.load[index], branch.load_ci95_half_width[index]])
        .filter(|[at, ..]| (low..=high).contains(at))
        .collect()
}

/// The branches of a small plot, each from its first position on over this reach.
pub(super) fn small(sheet: &Sheet, reach: f64) -> Vec<Layer> {
    let named = BRANCHES.iter().filter_map(|named| Some((named.1, sheet.curve.get(named.0)?)));
    named
        .map(|(ink, branch)| {
            let range = [branch.first, branch.first + reach];
            Layer::Line(ink, rows(branch, Some(range)).iter().map(|[at, load, _]| (at - branch.first, *load)).collect())
        })
        .collect()
}
