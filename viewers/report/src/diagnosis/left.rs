//! What no effect took away.

use identification::diagnosis::{Diagnosis, Verdict};
use maud::{Markup, html};

use super::{Numbering, floors, maps};
use crate::ink::Ink;
use crate::numbers::{three, two};

pub(super) fn section(found: &Diagnosis, numbers: &mut Numbering) -> Markup {
    let significant = found.where_after.iter().filter(|location| location.significant).count();
    html! {
        p {
            "The final model leaves " (three(found.heldout_rms_after)) " mNm RMS of the held-out capture, "
            (floors(found, found.heldout_rms_after)) " times the noise floor. "
            @match (found.verdict, significant) {
                (Verdict::OutsideLibrary, 0) => "It goes with no single quantity beyond chance: what is missing depends on several at \
                    once, on the past, or on something that was not measured.",
                (Verdict::OutsideLibrary, _) => "This is its shape:",
                (_, 0) => "No quantity explains any of it beyond chance.",
                (_, _) => "Some of it still goes with the quantities below, too little of it to be worth the name of an effect.",
            }
        }
        @if found.steps.is_empty() && significant == 0 {
            p.note { "Nothing was added, so the maps of what is left are those above." }
        } @else if significant > 0 || found.verdict == Verdict::OutsideLibrary {
            (maps::maps(&found.where_after, Ink::After, "What is left, and where", numbers))
            (maps::table(&found.where_after))
        } @else {
            (maps::before_and_after(&found.locations, &found.where_after, numbers))
            (maps::table(&found.where_after))
        }
        (partial(found))
    }
}

fn partial(found: &Diagnosis) -> Markup {
    if found.partial.is_empty() {
        return html! {};
    }
    let outside = found.verdict == Verdict::OutsideLibrary;
    html! {
        p {
            @if outside {
                "Effects that explain part of it and are not what is missing:"
            } @else {
                "Effects that would explain part of what is left, too little or too unsteadily to be named:"
            }
        }
        ul {
            @for partial in &found.partial {
                li { code { (partial.effect) } " explains " (two(partial.explains_percent)) " % of the mean square above the noise" }
            }
        }
    }
}
