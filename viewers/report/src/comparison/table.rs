//! The parameters of the knobs side by side, as the paper's Tables 5 and 6 have them.

use maud::{Markup, html};

use super::input::{ComparedKnob, ComparedQuality, ComparedValue, Comparison, PaperValue};
use crate::numbers::{Digits, count, printed, two};
use crate::parameter_table::name_cells;

/// Most columns of values side by side on a page of A4.
pub(super) const MOST_COLUMNS: usize = 5;
/// Digits of a value without an interval.
const DIGITS: i32 = 4;

/// The tables, as many as it takes, with their legend.
pub(super) fn parameters(compared: &Comparison) -> Markup {
    let names = compared.parameter_names();
    let any_paper = compared.knobs.iter().any(|knob| knob.paper.is_some());
    html! {
        @for knobs in compared.knobs.chunks(MOST_COLUMNS) { (one_table(knobs, &names)) }
        p.note {
            "Bold: the value. Below it half its 95 % interval, which allows for residuals that are correlated in time, and of several \
             captures for how they differ. Friction is a magnitude in both directions; detents have a positive amplitude."
            @if any_paper {
                " " span.paper { "Paper: " } "the value in Table 5 or 6 of Swindells and MacLean 2007, in the same signs; where the paper \
                 prints another sign, what it prints follows in brackets. The paper’s intervals are of the torque, not of the \
                 parameters: they are in the row " code { "mean_ci95_mnm" } "."
            }
        }
    }
}

fn one_table(knobs: &[ComparedKnob], names: &[&'static str]) -> Markup {
    let has = |knob: &ComparedKnob, name: &str| knob.unit(name).is_some();
    html! {
        div.scroll {
            table.parameters.compared.side {
                thead {
                    tr {
                        th { "parameter" }
                        th { "symbol" }
                        @for knob in knobs { th.number { (knob.name) span.faint { (knob.origin()) } } }
                        th { "unit" }
                    }
                }
                tbody {
                    @for name in names.iter().filter(|name| knobs.iter().any(|knob| has(knob, name))) {
                        tr {
                            (name_cells(name))
                            @for knob in knobs { (cell(knob, name)) }
                            td.unit { (dynamics::printed_unit(knobs.iter().find_map(|knob| knob.unit(name)).unwrap_or_default())) }
                        }
                    }
                    (quality(knobs, "residual_rms_mnm", "RMS of measured minus model torque", "mNm", |of| two(of.residual_rms_mnm)))
                    (quality(knobs, "relative_error_percent", "the same of the measured torque", "%", |of| {
                        two(of.relative_error_percent)
                    }))
                    (quality(knobs, "mean_ci95_mnm", "mean half width of the model torque’s 95 % interval", "mNm", |of| {
                        two(of.mean_ci95_mnm)
                    }))
                    (quality(knobs, "samples", "samples of all its captures", "", |of| count(of.samples as u64)))
                }
            }
        }
    }
}

/// A row on the fits themselves; nothing if no knob was fitted.
fn quality(
    knobs: &[ComparedKnob],
    name: &str,
    meaning: &str,
    unit: &str,
    show: impl Fn(&ComparedQuality) -> String,
) -> Markup {
    let paper = |knob: &ComparedKnob| {
        knob.paper.as_ref().filter(|_| name == "mean_ci95_mnm").map(|paper| printed(paper.mean_ci95_mnm))
    };
    html! {
        @if knobs.iter().any(|knob| knob.quality.is_some()) {
            tr {
                th scope="row" { code { (name) } span.meaning { (meaning) } }
                td {}
                @for knob in knobs {
                    td.number {
                        @if let Some(quality) = &knob.quality { (show(quality)) } @else { "–" }
                        @if let Some(words) = paper(knob) { span.paper { "paper " (words) } }
                    }
                }
                td.unit { (unit) }
            }
        }
    }
}

fn cell(knob: &ComparedKnob, name: &str) -> Markup {
    let paper = knob.paper.as_ref().and_then(|paper| paper.parameters.get(name));
    html! {
        td.number {
            @if let Some(own) = knob.parameters.get(name) { (value(own)) } @else { "–" }
            @if let Some(paper) = paper { (paper_value(paper)) }
        }
    }
}

/// A value with its interval below it.
pub(super) fn value(own: &ComparedValue) -> Markup {
    let ComparedValue { value, ci95_half_width, .. } = own;
    let Some(value) = *value else { return html! { span.undetermined { "not identifiable" } } };
    let half = ci95_half_width.unwrap_or(f64::NAN);
    let digits = if half > 0.0 { Digits::of_interval(value, half) } else { Digits::significant(value, DIGITS) };
    html! {
        strong { (digits.show(value)) }
        @if half > 0.0 { span.faint { "±\u{a0}" (digits.show(half)) } }
    }
}

fn paper_value(paper: &PaperValue) -> Markup {
    let PaperValue { value, printed: as_printed, .. } = *paper;
    let differs = (value - as_printed).abs() > 1e-9 * value.abs();
    let shown = Digits::significant(value, 2).show(value);
    html! {
        span.paper { "paper " (shown) @if differs { " (" (printed(as_printed)) ")" } }
    }
}
