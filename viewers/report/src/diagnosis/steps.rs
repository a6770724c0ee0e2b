//! An effect that was added: what it is, its parameters, and why it and no other.

use dynamics::{EffectKind, effects};
use identification::diagnosis::{Diagnosis, Row, Step, Value};
use identification::statistics::half_width;
use maud::{Markup, html};

use super::{Numbering, alone, floors, rivals};
use crate::intervals::picture;
use crate::numbers::{Digits, three, two};
use crate::page::uppercase_first;
use crate::parameter_table::name_cells;

/// Digits of a parameter without an interval.
const DIGITS: i32 = 4;

pub(super) fn section(found: &Diagnosis, index: usize, heldout: &[Row], numbers: &mut Numbering) -> Markup {
    let step = &found.steps[index];
    let kind = effects::by_name(step.effect);
    html! {
        section {
            h2 { "Step " (index + 1) ": " (step.effect) }
            @if let Some(kind) = kind {
                p { (uppercase_first(kind.description)) "." span.source { " " (uppercase_first(kind.source)) "." } }
            }
            p { (why(found, step)) }
            @if !step.detents.is_empty() {
                (detents(step))
            } @else if step.parameters.is_empty() {
                p.note { "Its parameters are not in the final model." }
            } @else {
                (parameters(step, kind))
            }
            @if let Some(figure) = alone::figure(found, step, heldout) { (figure.numbered(numbers.next())) }
            (rivals::figure(found, step).numbered(numbers.next()))
            (others(step))
        }
    }
}

fn why(found: &Diagnosis, step: &Step) -> String {
    format!(
        "With it the held-out gap goes from {} to {} mNm ({} times the noise floor) and that of the training capture from {} to {} \
         mNm; the null effect leaves {} mNm. The evidence for it is {} nats, and stretch after stretch it explains more, by {} standard \
         errors. Among all effects tried here the rate of false discoveries is {}.",
        three(step.heldout_rms_before),
        three(step.heldout_rms_after),
        floors(found, step.heldout_rms_after),
        three(step.train_rms_before),
        three(step.train_rms_after),
        three(step.placebo_rms),
        three(step.evidence),
        two(step.steadiness),
        three(step.false_discovery_rate)
    )
}

/// Unequal detents one by one.
fn detents(step: &Step) -> Markup {
    let cell = |value: &Value, factor: f64| {
        let half =
            value.ci95.map_or_else(String::new, |[low, high]| format!(" ± {}", two(0.5 * factor * (high - low))));
        html! { td.number { (three(factor * value.value)) (half) } }
    };
    let degrees = 1.0_f64.to_degrees();
    html! {
        table {
            thead { tr { th { "rest, °" } th { "pitch, °" } th { "peak, mNm" } th { "trough, mNm" } } }
            tbody {
                @for detent in &step.detents {
                    tr {
                        (cell(&detent.rest, degrees)) (cell(&detent.pitch, degrees)) (cell(&detent.peak, 1.0))
                        (cell(&detent.trough, 1.0))
                    }
                }
            }
        }
    }
}

/// The effect's parameters in the order of its law.
fn parameters(step: &Step, kind: Option<&'static EffectKind>) -> Markup {
    let place = |name: &str| {
        kind.and_then(|kind| kind.parameters.iter().position(|parameter| parameter.name == name)).unwrap_or(usize::MAX)
    };
    let mut ordered: Vec<(&str, &Value)> = step.parameters.iter().map(|(name, value)| (*name, value)).collect();
    ordered.sort_by_key(|(name, _)| place(name));
    html! {
        div.scroll {
            table.parameters {
                thead {
                    tr {
                        th { "parameter" }
                        th { "symbol" }
                        th.number { "value" }
                        th.number { "95 % interval" }
                        th { span.sr { "interval as a picture" } }
                        th { "unit" }
                    }
                }
                tbody { @for (name, value) in ordered { (row(name, value)) } }
            }
        }
        p.note {
            "Values in the final model. Intervals are of the training capture and allow for residuals that are correlated in time; a \
             dash where the data do not bound the parameter or it was not free."
        }
    }
}

fn row(name: &str, value: &Value) -> Markup {
    let half = value.ci95.map_or(f64::NAN, |ci95| half_width(value.value, ci95));
    let digits = match value.ci95 {
        Some(_) => Digits::of_interval(value.value, half),
        None => Digits::significant(value.value, DIGITS),
    };
    html! {
        tr {
            (name_cells(name))
            td.number.value { (digits.show(value.value)) }
            td.number { @if let Some(interval) = value.ci95 { (digits.span(interval)) } @else { "–" } }
            td { @if let Some(interval) = value.ci95 { (picture(value.value, interval, None, None)) } }
            td.unit { (dynamics::printed_unit(value.unit)) }
        }
    }
}

/// Ties, the closest rival, and who is ruled out and why.
fn others(step: &Step) -> Markup {
    let closest = step.rivals.iter().find(|rival| rival.disqualified.is_none());
    let ruled_out = || step.rivals.iter().filter_map(|rival| Some((rival.effect, rival.disqualified.as_deref()?)));
    html! {
        @if !step.ties.is_empty() {
            p.tie {
                strong { "A tie." } " These captures cannot tell " code { (step.effect) } " from "
                @for (index, tie) in step.ties.iter().enumerate() {
                    @if index > 0 { (if index + 1 == step.ties.len() { " or " } else { ", " }) }
                    code { (tie) }
                }
                ": the difference in evidence is too small or not steady."
            }
        } @else if let Some(rival) = closest {
            @let lead = step.evidence - rival.evidence;
            p {
                "No tie: the closest rival, " code { (rival.effect) } ", has " (three(lead.abs())) " nats " (if lead < 0.0 { "more" } else { "less" })
                " evidence and leaves " (three(rival.heldout_rms_after)) " mNm of the held-out capture."
            }
        } @else {
            p { "No rival could take its place." }
        }
        @if ruled_out().next().is_some() {
            p.note {
                "† Ruled out: "
                @for (index, (effect, reason)) in ruled_out().enumerate() {
                    @if index > 0 { "; " }
                    code { (effect) } ", because " (reason)
                }
                "."
            }
        }
    }
}
