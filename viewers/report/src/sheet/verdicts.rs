//! The page of verdicts: one line a unit.

use maud::{Markup, html};
use serde::Serialize;
use sheet::{FigureVerdict, Judgement, Verdict};

use super::tables::with_interval;
use crate::numbers::three;
use crate::page::document;

/// Units with their verdicts.
#[derive(Clone, Debug)]
pub struct VerdictsPage<'a> {
    /// What the specification is of; may be empty.
    pub name: &'a str,
    /// Largest risk of a wrong verdict.
    pub risk: f64,
    /// The units in the order in which they were given.
    pub units: &'a [JudgedUnit],
    /// Version of the program that made the page.
    pub software_version: &'a str,
}

/// A unit with its verdict.
#[derive(Clone, Debug, Serialize)]
pub struct JudgedUnit {
    /// The unit's file or folder.
    pub unit: String,
    /// The verdict.
    #[serde(flatten)]
    pub judgement: Judgement,
}

pub(crate) fn verdicts_page(page: &VerdictsPage<'_>) -> Markup {
    let count = |verdict| page.units.iter().filter(|unit| unit.judgement.verdict == verdict).count();
    let title = if page.name.is_empty() { "Verdicts" } else { page.name };
    let content = html! {
        header {
            p.kind { "Units against a specification" }
            h1 { (title) }
            p.verdict {
                (count(Verdict::Pass)) " pass, " (count(Verdict::Fail)) " fail, " (count(Verdict::Undecided)) " undecided; at most "
                (three(100.0 * page.risk)) " % risk of a wrong verdict."
            }
        }
        section {
            h2 { "Unit by unit" }
            div.scroll {
                table.compared {
                    thead { tr { th { "unit" } th { "verdict" } th { "figures" } th { "reasons" } } }
                    tbody.plain.units {
                        @for JudgedUnit { unit, judgement } in page.units {
                            tr {
                                th scope="row" { (unit) }
                                td { span class=(class(judgement.verdict)) { (judgement.verdict.word()) } }
                                td.words {
                                    @for figure in &judgement.figures { div { code { (figure.figure) } " " (words(figure)) } }
                                }
                                td.words { @for reason in &judgement.reasons { div { (reason) } } }
                            }
                        }
                    }
                }
            }
        }
        section {
            h2 { "How a verdict is made" }
            p {
                "A unit passes if every figure clears its limits by as many standard errors as the stated risk asks for, and fails if one lies \
                 beyond a limit by as many as its share of that risk asks for. Between the two the data do not tell: such a unit is undecided, and a \
                 longer capture or more of them narrow the interval. Figures and their definitions are those of the data sheet."
            }
        }
        footer { "Made by haptic-camera " (page.software_version) "." }
    };
    document(title, &content)
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Pass => "inside",
        Verdict::Undecided => "undetermined",
        Verdict::Fail => "outside",
    }
}

fn words(figure: &FigureVerdict) -> String {
    let unit = figure.unit;
    let value = figure
        .value
        .zip(figure.ci95)
        .map_or_else(|| "not determined".to_owned(), |(value, ci95)| format!("{} {unit}", with_interval(value, ci95)));
    let limits = match (figure.limits.min, figure.limits.max) {
        (Some(min), Some(max)) => format!(", may be {} to {}", three(min), three(max)),
        (Some(min), None) => format!(", at least {}", three(min)),
        (None, Some(max)) => format!(", at most {}", three(max)),
        (None, None) => String::new(),
    };
    format!("{value}{limits}")
}
