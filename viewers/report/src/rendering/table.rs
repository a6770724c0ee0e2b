//! The parameters of a rendered knob beside those intended.

use identification::statistics::half_width;
use maud::{Markup, html};

use super::RenderedParameter;
use crate::intervals::picture;
use crate::numbers::{Digits, fixed, three};
use crate::parameter_table::name_cells;

/// The table with its legend.
pub(super) fn parameters(parameters: &[RenderedParameter]) -> Markup {
    html! {
        div.scroll {
            table.compared {
                thead {
                    tr {
                        th { "parameter" }
                        th { "symbol" }
                        th.number { "intended" }
                        th.number { "rendered" }
                        th.number { "95 % interval" }
                        th { span.sr { "interval as a picture" } }
                        th.number { "off by" }
                        th { "unit" }
                    }
                }
                tbody { @for parameter in parameters { (row(parameter)) } }
            }
        }
        p.note {
            "Dot and whiskers: the rendered value and its 95 % interval, which allows for residuals that are correlated in time and \
             of varying size. Upright tick: the intended value."
        }
    }
}

fn row(parameter: &RenderedParameter) -> Markup {
    let RenderedParameter { name, unit, intended, rendered, ci95, difference_percent, passed, reason } = parameter;
    let Some(value) = *rendered else {
        return html! {
            tr.undetermined {
                (name_cells(name))
                td.number { (three(*intended)) }
                td.reason colspan="4" {
                    strong { "not identifiable" }
                    @if let Some(reason) = reason { ": " (reason) }
                }
                td.unit { (unit) }
            }
        };
    };
    let half = ci95.map_or(f64::NAN, |ci95| half_width(value, ci95));
    let digits = Digits::of_interval(value, half);
    let inside = ci95.map(|[low, high]| (low..=high).contains(intended));
    html! {
        tr {
            (name_cells(name))
            td.number { (Digits::significant(*intended, 4).show(*intended)) }
            td.number.value { (digits.show(value)) }
            td.number { @if let Some(interval) = ci95 { (digits.span(*interval)) } @else { "–" } }
            td { @if let Some(interval) = ci95 { (picture(value, *interval, None, Some(*intended))) } }
            td.number {
                @if let Some(percent) = difference_percent { (fixed(*percent, 2)) "\u{a0}%" } @else { "–" }
                @match (passed, inside) {
                    (Some(true), Some(true)) => span.inside { "in its interval" },
                    (Some(true), _) => span.inside { "small enough" },
                    (Some(false), _) => span.outside { "too far" },
                    (None, _) => {},
                }
            }
            td.unit { (unit) }
        }
    }
}
