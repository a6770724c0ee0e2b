//! The parameters with their intervals and, on a simulated rig, the truth.

use dynamics::{EffectKind, Model, ParameterKind, effects};
use identification::Parameter;
use identification::statistics::nearest_turn;
use maud::{Markup, html};

use crate::FitPage;
use crate::intervals::picture;
use crate::numbers::{Digits, three};

/// Rounding allowed at the ends of an interval, as a share of the value.
const ROUNDING: f64 = 1e-9;

/// The table with its legend.
pub(crate) fn parameter_table(page: &FitPage<'_>) -> Markup {
    let known = page.truth.is_some();
    let columns = if known { 5 } else { 4 };
    html! {
        div.scroll {
            table.parameters {
                thead {
                    tr {
                        th { "parameter" }
                        th { "symbol" }
                        th.number { "value" }
                        th.number { "95 % interval" span.faint { "textbook interval" } }
                        th { span.sr { "interval as a picture" } }
                        th { "unit" }
                        @if known { th.number { "true value" } }
                    }
                }
                tbody {
                    @for group in page.fit.parameters.0.chunk_by(same_reason) {
                        @for (index, parameter) in group.iter().enumerate() {
                            @if let Some(value) = parameter.value {
                                (estimate_cells(page, parameter, value))
                            } @else {
                                tr.undetermined {
                                    (name_cells(parameter.name))
                                    @if index == 0 {
                                        td.reason colspan=(columns) rowspan=(group.len()) { (not_identifiable(page, group)) }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
        p.note {
            "Whiskers and dark figures: 95 % interval, which allows for residuals that are correlated in time and of varying size. \
             Thick bar and pale figures: the textbook's, for independent residuals of one size; mostly too narrow."
            @if known { " Upright tick: the true value of the simulated knob." }
        }
        @if let Some(truth) = page.truth { (not_fitted(page, truth)) }
    }
}

fn estimate_cells(page: &FitPage<'_>, parameter: &Parameter, value: f64) -> Markup {
    let half = parameter.half_width().unwrap_or(f64::NAN);
    let digits = Digits::of_interval(value, half);
    let truth = true_value(page.truth, parameter.name, Some(value));
    html! {
        tr {
            (name_cells(parameter.name))
            td.number.value { (digits.show(value)) }
            td.number {
                @if let Some(interval) = parameter.ci95 { (digits.span(interval)) } @else { "–" }
                @if let Some(interval) = parameter.ci95_textbook { span.faint { (digits.span(interval)) } }
            }
            td { @if let Some(interval) = parameter.ci95 { (picture(value, interval, parameter.ci95_textbook, truth)) } }
            td.unit { (dynamics::printed_unit(parameter.unit)) }
            @if page.truth.is_some() { td.number { (truth_words(truth, parameter.ci95, digits)) } }
        }
    }
}

/// Whether neighbours are not identifiable for the same reason; they share a cell.
fn same_reason(one: &Parameter, next: &Parameter) -> bool {
    one.value.is_none() && next.value.is_none() && one.reason == next.reason
}

fn not_identifiable(page: &FitPage<'_>, group: &[Parameter]) -> Markup {
    let reason = group.first().and_then(|parameter| parameter.reason.as_deref());
    html! {
        strong { "not identifiable" }
        @if let Some(reason) = reason { ": " (reason) }
        @for parameter in group {
            @if let Some(truth) = true_value(page.truth, parameter.name, None) {
                span.truly { "true value of " code { (parameter.name) } ": " (three(truth)) " " (parameter.unit) }
            }
        }
    }
}

/// Whether an interval holds the true value, but for rounding; `None` without one.
#[must_use]
pub fn holds(ci95: Option<[f64; 2]>, truth: f64) -> Option<bool> {
    let rounding = ROUNDING * truth.abs();
    ci95.map(|[low, high]| (low - rounding..=high + rounding).contains(&truth))
}

/// The true value and whether the interval holds it.
pub(crate) fn truth_words(truth: Option<f64>, ci95: Option<[f64; 2]>, digits: Digits) -> Markup {
    let Some(truth) = truth else { return html! { "none" } };
    html! {
        (digits.show(truth))
        @match holds(ci95, truth) {
            Some(true) => span.inside { " inside" },
            Some(false) => span.outside { " outside" },
            None => {},
        }
    }
}

/// Name, meaning and symbol of a parameter.
pub(crate) fn name_cells(name: &str) -> Markup {
    let kind = kind(name).map(|(_, kind)| kind);
    html! {
        th scope="row" {
            code { (name) }
            @if let Some(kind) = kind { span.meaning { (kind.description) } }
        }
        td.symbol { @if let Some(kind) = kind { i { (kind.symbol) } } }
    }
}

/// Parameters of the simulated knob that the fit does not have.
fn not_fitted(page: &FitPage<'_>, truth: &Model) -> Markup {
    let missing: Vec<_> = truth.parameters().filter(|(kind, _)| page.fit.parameters.get(kind.name).is_none()).collect();
    html! {
        @if !missing.is_empty() {
            p.note {
                "The simulated knob also has "
                @for (index, (kind, value)) in missing.iter().enumerate() {
                    @if index > 0 { ", " }
                    code { (kind.name) } " " (three(*value)) (dynamics::spaced_unit(kind.unit))
                }
                ", which are no part of this fit."
            }
        }
    }
}

fn kind(name: &str) -> Option<(&'static EffectKind, &'static ParameterKind)> {
    effects::ALL
        .iter()
        .flat_map(|effect| effect.parameters.iter().map(move |kind| (*effect, kind)))
        .find(|(_, kind)| kind.name == name)
}

/// The true value in the form of the fit: detents with positive amplitude, their phase in the turn of the fitted one.
#[must_use]
pub fn true_value(truth: Option<&Model>, name: &str, near: Option<f64>) -> Option<f64> {
    let truth = truth?;
    let value = truth.parameter(name)?;
    let detent = &effects::detent::KIND;
    if !detent.parameters.iter().any(|kind| kind.name == name) {
        return Some(value);
    }
    let [amplitude, _, phase] = *truth.effect(detent.name)?.values() else { return Some(value) };
    let (amplitude, phase) = effects::detent::canonical(amplitude, phase);
    Some(if name == detent.parameters[0].name {
        amplitude
    } else if name == detent.parameters[2].name {
        near.map_or(phase, |near| nearest_turn(phase, near))
    } else {
        value
    })
}
