//! A forest plot of each parameter over all knobs and captures.

use maud::{Markup, html};

use super::input::{ComparedCapture, ComparedKnob, ComparedValue, Comparison};
use super::scale::Scale;

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
    own: Option<&'a ComparedValue>,
    /// Whether it is what the knob's column in the table shows.
    sums_up: bool,
    paper: Option<f64>,
    y: f64,
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
                        " A cross that lies off its diamond is no fault by itself: the paper gives two digits, and no intervals of \
                         single parameters."
                    }
                }
            }
        }
    })
}

fn plot(name: &str, knobs: &[ComparedKnob]) -> Option<Markup> {
    let (rows, separators, bottom) = rows(name, knobs);
    let told = || rows.iter().filter_map(|row| Some((row.own?.value?, row.own?.ci95)));
    let papers = || rows.iter().filter_map(|row| row.paper);
    if told().next().is_none() || told().count() + papers().count() < 2 {
        return None;
    }
    let ends = told().flat_map(|(value, ci95)| [Some(value), ci95.map(|ends| ends[0]), ci95.map(|ends| ends[1])]);
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
        let mut add = |label: String, own, sums_up, paper| {
            rows.push(Row { label, own, sums_up, paper, y: top + 0.5 * ROW });
            top += ROW;
        };
        let told = |capture: &ComparedCapture| capture.parameters.get(name).is_some_and(|own| own.value.is_some());
        if knob.captures.len() > 1 && knob.captures.iter().any(told) {
            for capture in &knob.captures {
                add(format!("capture {}", capture.number), capture.parameters.get(name), false, None);
            }
        }
        let paper = knob.paper.as_ref().and_then(|paper| Some(paper.parameters.get(name)?.value));
        add(shortened(&knob.name), knob.parameters.get(name), true, paper);
    }
    (rows, separators, top)
}

fn marks(row: &Row<'_>, x: &impl Fn(f64) -> String) -> Markup {
    let Row { label, own, sums_up, paper, y } = row;
    let value = own.and_then(|own| own.value);
    let y_text = short(*y);
    html! {
        text class=(if *sums_up { "title" } else { "label" }) x=(LEFT - 10.0) y=(y_text) dy="0.35em" text-anchor="end" { (label) }
        @if let (Some(value), Some([low, high])) = (value, own.and_then(|own| own.ci95)) {
            path class={"line " (if *sums_up { "model" } else { "label" })} d={
                "M" (x(low)) " " (y_text) "H" (x(high)) "M" (x(low)) " " (short(y - END)) "v" (2.0 * END)
                "M" (x(high)) " " (short(y - END)) "v" (2.0 * END)
            } {}
            @if !sums_up { circle.point cx=(x(value)) cy=(y_text) r="3" {} }
        }
        @if let (Some(value), true) = (value, *sums_up) {
            path.diamond.model d={
                "M" (x(value)) " " (short(y - DIAMOND)) "l" (DIAMOND) " " (DIAMOND) "l" (-DIAMOND) " " (DIAMOND)
                "l" (-DIAMOND) " " (-DIAMOND) "Z"
            } {}
        }
        @if let Some(paper) = paper {
            path.line.cross.reference d={
                "M" (x(*paper)) " " (y_text) "m" (-CROSS) " " (-CROSS) "l" (2.0 * CROSS) " " (2.0 * CROSS)
                "m0 " (-2.0 * CROSS) "l" (-2.0 * CROSS) " " (2.0 * CROSS)
            } {}
        }
        @if own.is_some() && value.is_none() {
            text.label x=(LEFT) y=(y_text) dy="0.35em" { "cannot be told" }
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

fn short(units: f64) -> String {
    format!("{units:.1}")
}
