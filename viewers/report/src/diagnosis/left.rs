//! What no effect took away.

use identification::diagnosis::{Diagnosis, Verdict};
use maud::{Markup, html};

use super::shape::shape;
use super::{Numbering, floors, maps};
use crate::numbers::{three, two};
use crate::plot::ink::Ink;
use crate::verdict::LIKE_NOISE;

pub(super) fn section(found: &Diagnosis, numbers: &mut Numbering) -> Markup {
    let significant = found.where_after.iter().filter(|location| location.significant).count();
    html! {
        p {
            "The final model leaves " (three(found.heldout_rms_after)) " mNm RMS of the held-out capture, "
            (floors(found, found.heldout_rms_after)) " times the noise floor. "
            (kind_of_rest(found, significant))
        }
        @if found.steps.is_empty() {
            @if let Some(location) = found.where_after.iter().find(|location| location.significant) {
                p { "It goes with " (maps::words(location.coordinate)) ". " @if let Some(shape) = shape(location) { (shape) } }
            }
            p.note { "Nothing was added, so the maps of what is left are those above." }
        } @else {
            @if significant > 0 || found.verdict == Verdict::OutsideLibrary {
                (maps::maps(&found.where_after, Ink::After, "What is left, and where", numbers))
            } @else {
                (maps::before_and_after(&found.locations, &found.where_after, numbers))
            }
            @if !found.where_after.is_empty() { (maps::table(&found.where_after)) }
        }
        (partial(found))
    }
}

/// What to think of the rest, given how many quantities it goes with.
fn kind_of_rest(found: &Diagnosis, significant: usize) -> &'static str {
    let like_noise = found.heldout_rms_after <= LIKE_NOISE * found.noise_floor_rms;
    match (found.verdict, significant) {
        (Verdict::OutsideLibrary, 0) => {
            "It goes with no single quantity beyond chance: what is missing depends on several at once, on the past, or on \
             something that was not measured."
        }
        (Verdict::OutsideLibrary, _) if !found.steps.is_empty() => "This is its shape:",
        (Verdict::OutsideLibrary, _) => "",
        (_, 0) if like_noise => "No quantity explains any of it beyond chance.",
        (_, 0) => {
            "That is more than noise, though no single quantity explains any of it beyond chance: the laws of the model are close \
             to the knob's and not quite these, or something smaller is missing too."
        }
        (_, _) => {
            "Some of it still goes with the quantities below, too little of it to be worth the name of an effect."
        }
    }
}

fn partial(found: &Diagnosis) -> Markup {
    if found.partial.is_empty() {
        return html! {};
    }
    html! {
        p { (found.partial_heading()) }
        ul {
            @for partial in &found.partial {
                li {
                    code { (partial.effect) } " explains " (two(partial.explains_percent)) " % of the mean square above the noise"
                    @if let Some(reason) = &partial.disqualified { ", but " (reason) }
                }
            }
        }
    }
}
