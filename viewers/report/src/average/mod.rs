//! The page of several captures and their mean.

mod captures;
mod forest;
mod table;

use identification::Agreement;
use maud::{Markup, html};

pub(crate) use self::table::difference;
use crate::AveragePage;
use crate::figures::{angle_figure, finite_points, velocity_figure};
use crate::numbers::{three, two};
use crate::page::{FEWEST_ROWS, document, footer, uppercase_first};
use crate::preparation::{is_map, method, not_identifiable, preparation};
use crate::verdict::findings;

pub(crate) fn average_page(page: &AveragePage<'_>) -> Markup {
    let AveragePage { average, fits, captures, truth: _ } = page;
    let title = title(page);
    let version = captures.first().map_or("", |capture| capture.software_version.as_str());
    let sources: Vec<&str> = captures.iter().map(|capture| capture.source.as_str()).collect();
    let content = html! {
        header {
            p.kind { "Mean of " (average.captures) " captures" }
            h1 { (title) }
            p.verdict { (uppercase_first(&findings(&average.fit))) }
            @if let Some(agreement) = average.agreement { p.completeness { (agreement_words(agreement)) } }
        }
        section {
            h2 { "Parameters" }
            (table::parameters(page))
        }
        section {
            h2 { "How the captures repeat" }
            (forest::figure(page).unwrap_or_else(|| html! { p { "No parameter was estimated from two captures." } }))
        }
        section {
            h2 { "The captures" }
            (captures::table(page))
        }
        (torques(page))
        section {
            h2 { "What the data could not tell" }
            (not_identifiable(&average.fit))
        }
        @for (index, fit) in fits.iter().enumerate() {
            section {
                h2 { "Preparation of capture " (index + 1) }
                (preparation(fit))
            }
        }
        section {
            h2 { "How the numbers were made" }
            (method(fits.iter().all(is_map)))
            (mean_method())
        }
        (footer(version, &sources.join(", ")))
    };
    document(&title, &content)
}

/// The knob, where all captures name the same; their files otherwise.
fn title(page: &AveragePage<'_>) -> String {
    let first = page.captures.first().map_or("", |capture| capture.knob.as_str());
    if !first.is_empty() && page.captures.iter().all(|capture| capture.knob == first) {
        return format!("Knob {first}, {} captures", page.captures.len());
    }
    let sources: Vec<&str> = page.captures.iter().map(|capture| capture.source.as_str()).collect();
    sources.join(" and ")
}

/// Whether captures agree.
pub(crate) fn agreement_words(agreement: Agreement) -> String {
    let Agreement { chi_squared, degrees_of_freedom, probability, birge_ratio } = agreement;
    let verdict = if agreement.agrees() {
        "The captures agree within their intervals"
    } else {
        "The captures differ by more than their intervals allow, and the mean's intervals are wider for it"
    };
    let probability = if probability < 1e-6 { "below 10⁻⁶".to_owned() } else { format!("of {}", two(probability)) };
    format!(
        "{verdict}: χ²\u{a0}=\u{a0}{} over {degrees_of_freedom} degrees of freedom, which chance alone exceeds with a probability \
         {probability}; Birge ratio {}.",
        three(chi_squared),
        three(birge_ratio)
    )
}

/// Torque of each capture against angle and velocity; the first says what to see.
fn torques(page: &AveragePage<'_>) -> Markup {
    let shown = page.fits.iter().zip(&page.captures).map(|(fit, capture)| (fit, capture, finite_points(fit)));
    html! {
        @for (index, (fit, capture, points)) in shown.enumerate() {
            section {
                h2 { "Capture " (index + 1) ": " (capture.source) }
                @if points.len() < FEWEST_ROWS {
                    p { "Too few rows of sliding motion for plots." }
                } @else if index == 0 {
                    p.lead { "The lines are the model as fitted to this capture alone." }
                    (angle_figure(fit, &points).numbered(2))
                    (velocity_figure(fit, &points).numbered(3))
                } @else {
                    (angle_figure(fit, &points).again(2 + 2 * index, 2))
                    (velocity_figure(fit, &points).again(3 + 2 * index, 3))
                }
            }
        }
    }
}

fn mean_method() -> Markup {
    html! {
        p {
            "The mean is that of whole parameter vectors by generalised least squares: each capture counts with the inverse \
             of the covariance of its parameters. Phases of detents are compared and averaged at the mean angle of all \
             captures, since at angle zero they follow the period. Where a parameter differs from capture to capture by more \
             than its intervals allow, the excess is taken for a scatter (DerSimonian and Laird 1986) that widens the mean's \
             interval; where the captures disagree it is added to the variances that weigh them as well. χ² is what the \
             captures leave of their mean without that scatter, compared with what Johansen (1980) gives for covariances that \
             are themselves estimates; its root over the degrees of freedom is the Birge ratio, 1 where captures differ as much \
             as their intervals say."
        }
    }
}
