//! A forest plot of each parameter over all knobs and captures.

use maud::{Markup, html};

use super::input::{ComparedCapture, ComparedKnob, ComparedValue, Comparison};
use super::scale::Scale;
use crate::plot::short;

/// Width of a plot, its room for row labels and its right margin, SVG units.
const WIDTH: f64 = 428.0;
const LEFT: f64 = 118.0;
const RIGHT: f64 = 18.0;
/// Height of a row, the room between knobs and that of the tick labels, SVG units.
const ROW: f64 = 17.0;
const BETWEEN: f64 = 7.0;
const BOTTOM: f64 = 24.0;
/// Half the height of an interval's ends, of a diamond and of the paper's cross, SVG units.
const END: f64 = 4.0;
const DIAMOND: f64 = 5.0;
const CROSS: f64 = 4.0;
/// Longest label of a row, letters.
const LETTERS: usize = 18;

/// What stands in one row.
struct Row<'a> {
    label: String,
    content: Content<'a>,
    y: f64,
}

enum Content<'a> {
    Capture(Option<&'a ComparedValue>),
    /// What the knob's column in the table shows.
    Knob(Option<&'a ComparedValue>),
    Paper(f64),
}

impl<'a> Content<'a> {
    fn own(&self) -> Option<&'a ComparedValue> {
        match self {
            Self::Capture(own) | Self::Knob(own) => *own,
            Self::Paper(_) => None,
        }
    }
}

/// The plots with their words; `None` where there is nothing to compare.
pub(super) fn figure(compared: &Comparison, number: usize) -> Option<Markup> {
    let plots: Vec<(&str, &str, Markup)> = compared
        .parameter_names()
        .into_iter()
        .filter_map(|name| {
            let unit = compared.knobs.iter().find_map(|knob| knob.unit(name))?;
            Some((name, unit, plot(name, &compared.knobs)?))
        })
        .collect();
    let any_paper = compared.knobs.iter().any(|knob| knob.paper.is_some());
    (!plots.is_empty()).then(|| {
        html! {
            figure.forests.wide {
                h3 { span.number { "Figure " (number) " " } "Each parameter of every knob" }
                ul.legend {
                    li { span.key.dots.label {} "a capture, with its 95 % interval" }
                    li { span.key.rhombus.model {} "a knob’s mean, or its only capture, or a model" }
                    @if any_paper { li { span.key.saltire.reference { "×" } "what the paper prints" } }
                }
                div.halves {
                    @for (name, unit, plot) in &plots {
                        div.forest {
                            p { code { (name) } " " span.axis { "(" (unit) ")" } }
                            (plot)
                        }
                    }
                }
                figcaption {
                    "Intervals without whiskers are narrower than their mark. Where the values of a parameter lie powers of ten apart \
                     the axis is logarithmic and says so."
                    @if any_paper {
                        " A cross a little off its diamond is no fault by itself: the paper gives two digits, and no intervals of \
                         single parameters."
                    }
                }
            }
        }
    })
}

fn plot(name: &str, knobs: &[ComparedKnob]) -> Option<Markup> {
    let (rows, separators, bottom) = rows(name, knobs);
    let estimates = || rows.iter().filter_map(|row| Some((row.content.own()?.value?, row.content.own()?.ci95)));
    let papers =
        || rows.iter().filter_map(|row| if let Content::Paper(value) = row.content { Some(value) } else { None });
    if estimates().next().is_none() || estimates().count() + papers().count() < 2 {
        return None;
    }
    let ends = estimates().flat_map(|(value, ci95)| [Some(value), ci95.map(|ends| ends[0]), ci95.map(|ends| ends[1])]);
    let scale = Scale::around(ends.flatten().chain(papers()));
    let x = |value: f64| short(LEFT + scale.share(value) * (WIDTH - LEFT - RIGHT));
    Some(html! {
        svg.plot xmlns="http://www.w3.org/2000/svg" viewBox={"0 0 " (WIDTH) " " (short(bottom + BOTTOM))} role="img"
            aria-label={"Values of " (name) ", knob by knob"} {
            @for (at, label) in scale.ticks() {
                path.line.grid d={"M" (x(at)) " 0V" (short(bottom))} {}
                text.label x=(x(at)) y=(short(bottom)) dy="1.3em" text-anchor="middle" { (label) }
            }
            @if let Some(zero) = scale.zero() { path.line.zero d={"M" (x(zero)) " 0V" (short(bottom))} {} }
            @if scale.is_logarithmic() { text.label x="0" y=(short(bottom)) dy="1.3em" { "logarithmic" } }
            @for y in &separators { path.line.grid d={"M0 " (short(*y)) "H" (WIDTH)} {} }
            @for row in &rows { (marks(row, &x)) }
        }
    })
}

/// The rows of every knob, the lines between knobs, and where the plot ends.
fn rows<'a>(name: &str, knobs: &'a [ComparedKnob]) -> (Vec<Row<'a>>, Vec<f64>, f64) {
    let mut rows = Vec::new();
    let mut separators = Vec::new();
    let mut top = 0.0;
    for (index, knob) in knobs.iter().enumerate() {
        if index > 0 {
            separators.push(top + 0.5 * BETWEEN);
            top += BETWEEN;
        }
        let mut add = |label: String, content| {
            rows.push(Row { label, content, y: top + 0.5 * ROW });
            top += ROW;
        };
        let has_value = |capture: &ComparedCapture| capture.parameters.get(name).is_some_and(|own| own.value.is_some());
        if knob.captures.len() > 1 && knob.captures.iter().any(has_value) {
            for capture in &knob.captures {
                add(format!("capture {}", capture.number), Content::Capture(capture.parameters.get(name)));
            }
        }
        add(shortened(&knob.name), Content::Knob(knob.parameters.get(name)));
        if let Some(printed) = knob.paper.as_ref().and_then(|paper| paper.parameters.get(name)) {
            add("paper".to_owned(), Content::Paper(printed.value));
        }
    }
    (rows, separators, top)
}

fn marks(row: &Row<'_>, x: &impl Fn(f64) -> String) -> Markup {
    let Row { label, content, y } = row;
    let y_text = short(*y);
    let (class, ink) = match content {
        Content::Capture(_) => ("label", "label"),
        Content::Knob(_) => ("title", "model"),
        Content::Paper(_) => ("reference", "reference"),
    };
    let value = content.own().and_then(|own| own.value);
    html! {
        text class=(class) x=(LEFT - 10.0) y=(y_text) dy="0.35em" text-anchor="end" { (label) }
        @if let Some([low, high]) = content.own().and_then(|own| own.ci95) {
            path class={"line " (ink)} d={
                "M" (x(low)) " " (y_text) "H" (x(high)) "M" (x(low)) " " (short(y - END)) "v" (2.0 * END)
                "M" (x(high)) " " (short(y - END)) "v" (2.0 * END)
            } {}
        }
        @match (content, value) {
            (Content::Capture(_), Some(value)) => circle.point cx=(x(value)) cy=(y_text) r="3" {},
            (Content::Knob(_), Some(value)) => path.diamond.model d={
                "M" (x(value)) " " (short(y - DIAMOND)) "l" (DIAMOND) " " (DIAMOND) "l" (-DIAMOND) " " (DIAMOND)
                "l" (-DIAMOND) " " (-DIAMOND) "Z"
            } {},
            (Content::Paper(value), _) => path.line.cross.reference d={
                "M" (x(*value)) " " (y_text) "m" (-CROSS) " " (-CROSS) "l" (2.0 * CROSS) " " (2.0 * CROSS)
                "m0 " (-2.0 * CROSS) "l" (-2.0 * CROSS) " " (2.0 * CROSS)
            } {},
            (Content::Capture(Some(_)) | Content::Knob(Some(_)), None) => text.label x=(LEFT) y=(y_text) dy="0.35em" {
                "not identifiable"
            },
            _ => {},
        }
    }
}

/// A name that fits the room for labels; the table above has all of it.
fn shortened(name: &str) -> String {
    if name.chars().count() <= LETTERS {
        return name.to_owned();
    }
    name.chars().take(LETTERS - 1).chain(['…']).collect()
}
