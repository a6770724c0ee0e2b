//! An interval as a small picture: whiskers, dot and, where it is known, the truth.

use identification::statistics::half_width;
use maud::{Markup, html};

/// Size of the picture, SVG units.
const SIZE: (f64, f64) = (110.0, 18.0);
/// Room at the ends, SVG units.
const MARGIN: f64 = 5.0;
/// Half widths of the interval within which a true value keeps its place; beyond, it stands at the edge.
const REACH: f64 = 3.0;

/// The 95 % interval around `value` as a line, the textbook one as a thicker line upon it, and a tick at the truth.
pub(crate) fn picture(value: f64, ci95: [f64; 2], textbook: Option<[f64; 2]>, truth: Option<f64>) -> Markup {
    let half = half_width(value, ci95);
    let farthest = truth.map_or(0.0, |truth| (truth - value).abs());
    let reach = half.max(farthest.min(REACH * half));
    if !(reach > 0.0 && reach.is_finite()) {
        return html! {};
    }
    let middle = 0.5 * SIZE.1;
    let x = |at: f64| {
        let share = ((at - value) / reach).clamp(-1.0, 1.0);
        format!("{:.1}", 0.5 * SIZE.0 + share * (0.5 * SIZE.0 - MARGIN))
    };
    html! {
        svg.interval xmlns="http://www.w3.org/2000/svg" viewBox={"0 0 " (SIZE.0) " " (SIZE.1)} aria-hidden="true" {
            path.whisker d={
                "M" (x(ci95[0])) " " (middle) "H" (x(ci95[1]))
                "M" (x(ci95[0])) " " (middle - 4.0) "v8M" (x(ci95[1])) " " (middle - 4.0) "v8"
            } {}
            @if let Some([low, high]) = textbook {
                path.textbook d={ "M" (x(low)) " " (middle) "H" (x(high)) } {}
            }
            @if let Some(truth) = truth {
                path.truth d={ "M" (x(truth)) " 1V17" } {}
            }
            circle cx=(x(value)) cy=(middle) r="3" {}
        }
    }
}
