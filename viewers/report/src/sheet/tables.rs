//! The figures as tables.

use maud::{Markup, html};
use shared_types::Axis;
use sheet::{Figure, Sheet};

use crate::numbers::{Digits, three};

/// A value with half its interval.
pub(super) fn with_interval(value: f64, [low, high]: [f64; 2]) -> String {
    let half = 0.5 * (high - low);
    Digits::of_interval(value, half).plus_minus(value, half)
}

fn with_unit(figure: Option<&Figure>) -> Option<String> {
    let figure = figure?;
    let value = figure.value?;
    let unit = figure.kind.unit;
    Some(match unit {
        "share" => format!("{}\u{a0}%", three(100.0 * value)),
        "rad" => format!("{}°", three(value.to_degrees())),
        "" => three(value),
        _ => format!("{}\u{a0}{}", three(value), unit.replace(' ', "\u{a0}")),
    })
}

/// The main figures of a control, in a sentence.
pub(super) fn headline(sheet: &Sheet) -> String {
    let figure = |name: &str| with_unit(sheet.figures.get(name));
    let words = match sheet.axis {
        Axis::Rotary => [
            figure("detent_count").map(|count| format!("{count} detents in a turn")),
            figure("detent_pitch").map(|pitch| format!("{pitch} apart")),
            figure("peak_torque").map(|peak| format!("peak {peak}")),
            figure("running_friction").map(|friction| format!("running friction {friction}")),
        ],
        Axis::Linear => [
            figure("collapse_force").map(|force| format!("collapse at {force}")),
            figure("collapse_travel").map(|travel| format!("after {travel}")),
            figure("snap").map(|snap| format!("snap {snap}")),
            figure("travel").map(|travel| format!("bottom-out after {travel}")),
        ],
    };
    let words: Vec<String> = words.into_iter().flatten().collect();
    if words.is_empty() { "no figure could be determined.".to_owned() } else { format!("{}.", words.join(", ")) }
}

/// Every figure with its definition.
pub(super) fn figures(sheet: &Sheet) -> Markup {
    let any_spread = sheet.in_order().any(|figure| figure.over.is_some());
    html! {
        div.scroll {
            table.compared {
                thead {
                    tr {
                        th { "figure" }
                        th.number { "value, ± half its 95 % interval" }
                        th { "unit" }
                        @if any_spread { th.number { "from detent to detent" span.faint { "spread; worst; number" } } }
                        th { "definition" }
                    }
                }
                tbody {
                    @for figure in sheet.in_order() {
                        @let kind = figure.kind;
                        tr {
                            th scope="row" { code { (kind.name) } }
                            td.number.value {
                                @if let Some((value, ci95)) = figure.value.zip(figure.ci95) { (with_interval(value, ci95)) } @else { "–" }
                            }
                            td.unit { (kind.unit) }
                            @if any_spread {
                                td.number {
                                    @if let Some(over) = figure.over { (three(over.spread)) "; " (three(over.worst)) "; " (over.number) }
                                }
                            }
                            td.words {
                                (kind.definition) " " span.faint { "Source: " (kind.source) "." }
                                @if let Some(reason) = &figure.reason { span.undetermined { "Not determined: " (reason) "." } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Each detent in each direction.
pub(super) fn detents(sheet: &Sheet) -> Markup {
    let names: Vec<&str> =
        sheet.detents.first().map(|detent| detent.figures.keys().copied().collect()).unwrap_or_default();
    html! {
        div.scroll {
            table.compared {
                thead {
                    tr {
                        th { "direction" }
                        th.number { "angle_rad" }
                        @for name in &names { th.number { (name) } }
                    }
                }
                tbody.plain {
                    @for detent in &sheet.detents {
                        tr {
                            th scope="row" { (detent.direction) }
                            td.number { (with_interval(detent.angle_rad, detent.angle_rad_ci95)) }
                            @for name in &names {
                                td.number { @if let Some(figure) = detent.figures.get(name) { (with_interval(figure.value, figure.ci95)) } }
                            }
                        }
                    }
                }
            }
        }
        p.note { "Where each detent rests, and what it takes to leave it in that direction; ± half the 95 % interval." }
    }
}
