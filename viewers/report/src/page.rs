//! The page from headline to footer.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figures::{
    angle_figure, effect_figures, excerpt_figure, finite_points, histogram_figure, order_figure, residual_figure,
    velocity_figure,
};
use crate::numbers::{count, three};
use crate::parameter_table::parameter_table;
use crate::preparation::{is_map, method, not_identifiable, preparation};
use crate::verdict::{completeness, findings};
use crate::{CaptureFacts, FigureNumbers, FitPage};

const STYLE: &str = include_str!("style.css");

/// Fewest rows that make a plot.
pub(crate) const FEWEST_ROWS: usize = 20;

pub(crate) fn fit_page(page: &FitPage<'_>) -> (Markup, FigureNumbers) {
    let FitPage { fit, capture, truth: _ } = page;
    let (figures, numbers) = figures(page);
    let content = html! {
        header {
            p.kind { "Fit of a capture" }
            h1 { (capture.title) }
            p.verdict { (uppercase_first(&findings(fit))) }
            @if let Some(words) = completeness(fit) { p.completeness { (words) } }
            (facts(capture))
        }
        section {
            h2 { "Parameters" }
            (parameter_table(page))
        }
        (figures)
        section {
            h2 { "What the data could not tell" }
            (not_identifiable(fit))
        }
        section {
            h2 { "Preparation" }
            (preparation(fit))
        }
        section {
            h2 { "How the numbers were made" }
            (method(is_map(fit)))
        }
        (footer(&capture.software_version, &capture.source))
    };
    (document(&capture.title, &content), numbers)
}

/// A page around its content.
pub(crate) fn document(title: &str, content: &Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                // Marks a page that a later one may replace.
                meta name="generator" content="haptic-camera";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { main { (content) } }
        }
    }
}

/// Who made the page, of what, and the units.
pub(crate) fn footer(software_version: &str, source: &str) -> Markup {
    html! {
        footer {
            "Made by haptic-camera " (software_version) " from " (source) ". Angles in rad, torques in mNm, times in s; \
             positive torque turns the knob towards positive angle."
        }
    }
}

/// The figures, and the numbers in their captions.
fn figures(page: &FitPage<'_>) -> (Markup, FigureNumbers) {
    let fit = page.fit;
    let points = finite_points(fit);
    if points.len() < FEWEST_ROWS {
        let words = html! {
            section { h2 { "Measured and model" } p { "Too few rows of sliding motion for plots." } }
        };
        return (words, FigureNumbers::new());
    }
    let effects = effect_figures(fit, &points);
    // A map has one speed only.
    let first = if is_map(fit) { 2 } else { 3 };
    let after = first + effects.len();
    let (excerpt, in_excerpt) = excerpt_figure(fit, &points);
    let (histogram, in_histogram) = histogram_figure(fit, &points);
    let (order, in_order) = order_figure(fit, &points);
    let markup = html! {
        section {
            h2 { "Measured and model" }
            (angle_figure(fit, &points).numbered(1))
            @if !is_map(fit) { (velocity_figure(fit, &points).numbered(2)) }
        }
        @if !effects.is_empty() {
            section {
                h2 { "Each effect by itself" }
                p.lead {
                    "Dots: the measured torque less everything in the model but the one effect. Line: that effect as fitted."
                }
                div.thirds { @for (index, figure) in effects.iter().enumerate() { (figure.numbered(first + index)) } }
            }
        }
        section {
            h2 { "In time" }
            (excerpt.numbered(after))
        }
        section {
            h2 { "What the model leaves over" }
            (residual_figure(fit, &points).numbered(after + 1))
            div.halves {
                (histogram.numbered(after + 2))
                (order.numbered(after + 3))
            }
        }
    };
    let numbers =
        [("torque_over_time", in_excerpt), ("residual_by_size", in_histogram), ("residual_by_order", in_order)];
    (markup, numbers.into())
}

/// What is known of a capture, in a strip.
pub(crate) fn facts(capture: &CaptureFacts) -> Markup {
    let CaptureFacts {
        title: _,
        source,
        knob,
        rig,
        captured_at,
        rate_hz,
        duration_s,
        samples,
        missed_ticks,
        gaps,
        real_time,
        software_version: _,
    } = capture;
    let text = |words: &str| (!words.is_empty()).then(|| words.to_owned());
    let facts = [
        ("file", text(source)),
        ("knob", text(knob)),
        ("rig", text(rig)),
        ("captured", text(captured_at)),
        ("rate", Some(format!("{} Hz", three(*rate_hz)))),
        ("duration", Some(format!("{} s", three(*duration_s)))),
        ("samples", Some(count(*samples))),
        ("missed ticks", missed_ticks.map(count)),
        ("gaps", gaps.map(count)),
        ("real time", real_time.map(|granted| if granted { "yes" } else { "no" }.to_owned())),
    ];
    html! {
        dl.facts {
            @for (name, words) in facts {
                @if let Some(words) = words { div { dt { (name) } dd { (words) } } }
            }
        }
    }
}

/// A note as a sentence.
pub(crate) fn sentence(note: &str) -> String {
    uppercase_first(note.trim_end_matches('.')) + "."
}

/// A text that begins with a capital letter.
pub(crate) fn uppercase_first(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().to_string() + letters.as_str())
}
