//! The captures behind the means: where they are from, and what each tells by itself.

use maud::{Markup, html};

use super::input::{ComparedCapture, ComparedKnob, Comparison};
use super::table::{MOST_COLUMNS, value};
use crate::average::{agreement_words, difference};
use crate::numbers::{count, three, two};
use crate::parameter_table::name_cells;

/// Every capture in a row of its own.
pub(super) fn list(compared: &Comparison) -> Markup {
    let captures = || compared.knobs.iter().flat_map(|knob| knob.captures.iter().map(move |capture| (knob, capture)));
    if captures().next().is_none() {
        return html! { p { "All that is compared are models; no capture was fitted." } };
    }
    let timed = captures().any(|(_, capture)| !capture.facts.captured_at.is_empty());
    html! {
        div.scroll {
            table {
                thead {
                    tr {
                        th.number { "no." }
                        th { "knob" }
                        th { "file" }
                        @if timed { th { "captured" } }
                        th.number { "rate (Hz)" }
                        th.number { "duration (s)" }
                        th.number { "samples" }
                        th.number { "residual RMS (mNm)" }
                        th.number { "of the torque (%)" }
                        th.number { "model’s interval (mNm)" }
                    }
                }
                tbody.plain {
                    @for (knob, ComparedCapture { number, facts, quality, .. }) in captures() {
                        tr {
                            td.number { (number) }
                            td.words { (knob.name) }
                            th.file scope="row" { (facts.source) }
                            @if timed { td { (facts.captured_at) } }
                            td.number { (three(facts.rate_hz)) }
                            td.number { (three(facts.duration_s)) }
                            td.number { (count(facts.samples)) }
                            td.number { (two(quality.residual_rms_mnm)) }
                            td.number { (two(quality.relative_error_percent)) }
                            td.number { "±\u{a0}" (two(quality.mean_ci95_mnm)) }
                        }
                    }
                }
            }
        }
    }
}

/// A table for each knob of several captures, with whether they agree.
pub(super) fn side_by_side(knob: &ComparedKnob) -> Markup {
    html! {
        h3 { (knob.name) ": its captures one by one" }
        @if let Some(agreement) = knob.agreement { p.lead { (agreement_words(agreement)) } }
        @for captures in knob.captures.chunks(MOST_COLUMNS - 1) {
            div.scroll {
                table.parameters.compared.side {
                    thead {
                        tr {
                            th { "parameter" }
                            th { "symbol" }
                            @for capture in captures { th.number { "capture " (capture.number) span.faint { "± 95 %" } } }
                            th.number { "difference" span.faint { "over its 95 %" } }
                            th { "unit" }
                        }
                    }
                    tbody {
                        @for (name, unit) in ordered(knob) {
                            tr {
                                (name_cells(name))
                                @for capture in captures {
                                    td.number { @if let Some(own) = capture.parameters.get(name) { (value(own)) } @else { "–" } }
                                }
                                (difference(knob.repeatability.get(name)))
                                td.unit { (unit) }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The parameters that some capture tells with their units, in the order in which a model lists them.
fn ordered(knob: &ComparedKnob) -> Vec<(&'static str, &'static str)> {
    let known = dynamics::effects::ALL.iter().flat_map(|effect| effect.parameters);
    let has_value = |name: &str| {
        let of = |capture: &ComparedCapture| capture.parameters.get(name).is_some_and(|own| own.value.is_some());
        knob.captures.iter().any(of)
    };
    known
        .filter(|kind| has_value(kind.name))
        .filter_map(|kind| Some((kind.name, knob.parameters.get(kind.name)?.unit)))
        .collect()
}
