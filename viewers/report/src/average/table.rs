//! The mean's parameters beside those of each capture.

use identification::statistics::half_width;
use identification::{Fit, Parameter, Repeatability};
use maud::{Markup, html};

use crate::AveragePage;
use crate::numbers::{Digits, two};
use crate::parameter_table::{name_cells, true_value, truth_words};

/// Most captures whose values stand in columns; of more the plots alone tell.
const MOST_COLUMNS: usize = 4;

/// The table with its legend.
pub(super) fn parameters(page: &AveragePage<'_>) -> Markup {
    let shown = if page.fits.len() <= MOST_COLUMNS { page.fits } else { &[] };
    let known = page.truth.is_some();
    html! {
        div.scroll {
            table.parameters.compared {
                thead {
                    tr {
                        th { "parameter" }
                        th { "symbol" }
                        th.number { "mean" span.faint { "95 % interval" } }
                        @for (index, _) in shown.iter().enumerate() { th.number { "capture " (index + 1) span.faint { "95 %" } } }
                        th.number { "difference" span.faint { "over its 95 %" } }
                        th { "unit" }
                        @if known { th.number { "true value" } }
                    }
                }
                tbody {
                    @for parameter in &page.average.fit.parameters.0 { (row(page, shown, parameter)) }
                }
            }
        }
        p.note {
            "Difference: largest less smallest value of the captures; below it how many times the 95 % interval of such a \
             difference that is, from the captures' own intervals. Up to 1 is what chance explains."
            @if shown.is_empty() { " Single captures are in the figure below." }
            @if let Some(angle_rad) = phase_angle_rad(page) {
                " Phases are compared at " (two(angle_rad)) " rad, the captures' mean angle; the columns show them at angle zero."
            }
        }
    }
}

fn row(page: &AveragePage<'_>, shown: &[Fit], parameter: &Parameter) -> Markup {
    let truth = true_value(page.truth, parameter.name, parameter.value);
    html! {
        tr {
            (name_cells(parameter.name))
            @match parameter.value.zip(parameter.ci95) {
                Some((value, ci95)) => {
                    @let digits = Digits::of_interval(value, half_width(value, ci95));
                    td.number.value { (digits.show(value)) span.faint { (digits.span(ci95)) } }
                },
                None => td.number { "–" span.faint { "not identifiable" } },
            }
            @for fit in shown { (cell(fit, parameter.name)) }
            (difference(page.average.repeatability.get(parameter.name)))
            td.unit { (parameter.unit) }
            @if page.truth.is_some() {
                @let half = parameter.ci95.map_or(f64::NAN, |[low, high]| 0.5 * (high - low));
                td.number { (truth_words(truth, parameter.ci95, Digits::of_interval(truth.unwrap_or_default(), half))) }
            }
        }
    }
}

/// What one capture tells of a parameter.
fn cell(fit: &Fit, name: &str) -> Markup {
    let own = fit.parameters.get(name).and_then(|own| own.value.zip(own.ci95));
    let Some((value, ci95)) = own else { return html! { td.number { "–" } } };
    let half = half_width(value, ci95);
    let digits = Digits::of_interval(value, half);
    html! { td.number { (digits.show(value)) span.faint { "±\u{a0}" (digits.show(half)) } } }
}

/// Largest less smallest value, and how many times its interval that is.
pub(crate) fn difference(record: Option<&Repeatability>) -> Markup {
    let Some(record) = record else { return html! { td.number { "–" } } };
    // As many decimals as the values, so that the difference can be checked by eye.
    let digits = Digits::of_interval(record.mean.value, record.difference_ci95);
    html! {
        td.number {
            (digits.show(record.difference))
            span class=(if record.ratio > 1.0 { "outside" } else { "faint" }) { (two(record.ratio)) "\u{a0}×" }
        }
    }
}

fn phase_angle_rad(page: &AveragePage<'_>) -> Option<f64> {
    page.average.repeatability.values().find_map(|record| record.at_angle_rad)
}
