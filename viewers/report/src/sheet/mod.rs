//! The pages of a data sheet, of verdicts, and of knobs side by side for the wall.

mod curves;
mod tables;
mod verdicts;
mod wall;

use maud::{Markup, html};
use shared_types::Axis;
use sheet::Sheet;

use crate::page::{document, uppercase_first};
pub(crate) use verdicts::verdicts_page;
pub use verdicts::{JudgedUnit, VerdictsPage};
pub(crate) use wall::wall_page;
pub use wall::{WallKnob, WallPage};

/// A data sheet with everything shown on its page.
#[derive(Clone, Debug)]
pub struct SheetPage<'a> {
    /// The sheet.
    pub sheet: &'a Sheet,
    /// Headline.
    pub title: String,
    /// The files that it was made of.
    pub sources: Vec<String>,
    /// Version of the program that made the page.
    pub software_version: String,
}

pub(crate) fn sheet_page(page: &SheetPage<'_>) -> Markup {
    let SheetPage { sheet, title, sources, software_version } = page;
    let content = html! {
        header {
            p.kind { "Data sheet" }
            h1 { (title) }
            p.verdict { (uppercase_first(&tables::headline(sheet))) }
        }
        section {
            h2 { "The curve" }
            (curves::figures(sheet))
        }
        section {
            h2 { "Figures" }
            (tables::figures(sheet))
        }
        @if !sheet.detents.is_empty() {
            section {
                h2 { "Detent by detent" }
                (tables::detents(sheet))
            }
        }
        section {
            h2 { "How the numbers were made" }
            (method(sheet))
        }
        (footer(sheet.axis, software_version, &sources.join(", ")))
    };
    document(title, &content)
}

/// Who made the page, of what, and the units.
fn footer(axis: Axis, software_version: &str, source: &str) -> Markup {
    let units = match axis {
        Axis::Rotary => {
            "Angles in rad, torques in mNm, energies in mJ; positive torque turns the knob towards positive angle."
        }
        Axis::Linear => {
            "Travels in mm, forces in N, energies in N mm, which is mJ; travel and force count into the control."
        }
    };
    html! {
        footer { "Made by haptic-camera " (software_version) " from " (source) ". " (units) }
    }
}

fn method(sheet: &Sheet) -> Markup {
    html! {
        p {
            @if sheet.runs > 1 {
                "Each of the " (sheet.runs) " curves" @if !sheet.presses.is_empty() { ", or presses of one," } " was read by itself, and a figure is the mean of what they gave. Its 95 % interval holds the \
                 figure of one more such curve: Student’s distribution times the deviation between the curves, times √(1 + 1/n), or times what \
                 each by itself leaves open where that is more."
            } @else {
                "The 95 % intervals come from the noise about the smoothed curve, drawn anew 200 times with the sign of each residual left to \
                 chance; they say how well this curve tells the figure, not how well another would repeat it."
            }
        }
        @if sheet.axis == Axis::Rotary {
            p {
                "The branches are cubic splines of the angle by least squares, as many knots to a detent as predict best what they were not fitted \
                 to. Where the control started, stopped or turned round is left out, since inertia takes torque there."
            }
        } @else {
            p {
                "Features are looked for on steps of 5 µm, smoothed over seven of them; energies are taken from the curve as it was measured."
            }
        }
    }
}
