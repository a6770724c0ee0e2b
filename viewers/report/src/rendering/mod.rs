//! The page of a rendering: the rendered knob, captured like any other, beside the model that it was to be.

mod figures;
mod input;
mod table;

use std::path::PathBuf;

use identification::diagnosis::Verdict;
use maud::{Markup, html};

pub use input::{
    AddedByRendering, HeldStill, LostMotion, RenderedParameter, Rendering, RenderingLimits, RenderingPage,
};

use crate::numbers::three;
use crate::page::{document, facts, footer, sentence};

pub(crate) fn rendering_page(page: &RenderingPage<'_>) -> Markup {
    let title = page.intended.name.as_str();
    let found = &page.rendering;
    let file_name = |path: &PathBuf| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let sources: Vec<String> = found.captures.iter().map(file_name).collect();
    let content = html! {
        header {
            p.kind { "A rendered knob beside its model" }
            h1 { (title) }
            p.verdict { (verdict(found)) }
            p.completeness { (torque_words(found)) }
            (facts(&found.capture))
        }
        section {
            h2 { "Parameters" }
            (table::parameters(&found.parameters))
        }
        section {
            h2 { "Intended and captured torque" }
            (figures::section(page))
        }
        section {
            h2 { "Held still" }
            p { (held_words(found.held_still)) }
        }
        section {
            h2 { "What the rendering adds" }
            p { (added_words(found.added.as_ref())) }
        }
        @if !found.notes.is_empty() {
            section {
                h2 { "What a reader should know" }
                ul { @for note in &found.notes { li { (sentence(note)) } } }
            }
        }
        section {
            h2 { "How the numbers were made" }
            (method(&found.limits))
        }
        (footer(&found.capture.software_version, &sources.join(", ")))
    };
    document(title, &content)
}

fn verdict(found: &Rendering) -> String {
    if found.passed {
        return "The rendered knob is the model’s.".to_owned();
    }
    let failed = found.parameters.iter().filter(|parameter| parameter.passed == Some(false));
    let mut reasons: Vec<String> = failed.map(|parameter| parameter.name.to_owned()).collect();
    if !found.torque_passes() {
        reasons.push("the torque".to_owned());
    }
    if !found.is_held_still() {
        reasons.push("how still it is held".to_owned());
    }
    format!("The rendered knob differs from the model in {}.", reasons.join(", "))
}

fn torque_words(found: &Rendering) -> String {
    format!(
        "While it slides, its torque differs from the model’s by {}\u{a0}mNm\u{a0}RMS of {}, that is {}\u{a0}%; at most {}\u{a0}% \
         pass. Rendered at {}\u{a0}Hz.",
        three(found.torque_error_rms_mnm),
        three(found.torque_rms_mnm),
        three(found.torque_error_percent),
        three(found.limits.torque_error_percent),
        three(found.rate_hz)
    )
}

fn held_words(held: Option<HeldStill>) -> String {
    match held {
        Some(HeldStill { torque_mnm, duration_s, encoder_steps }) => format!(
            "Under {} mNm, inside what it bears at rest, for {} s, the encoder read {} of its steps; less than one passes.",
            three(torque_mnm),
            three(duration_s),
            three(encoder_steps)
        ),
        None => "The model bears no torque at rest: there is nothing to hold.".to_owned(),
    }
}

/// The verdict of a diagnosis that began with the intended model.
fn added_words(added: Option<&AddedByRendering>) -> Markup {
    let Some(AddedByRendering { verdict, effects, heldout_rms_before, heldout_rms_after, noise_floor_rms }) = added
    else {
        return html! { "A diagnosis could not tell; the notes say why." };
    };
    let left = |rms_mnm: f64| format!("{}\u{a0}mNm", three(rms_mnm));
    let from = format!(
        "On another motion the intended model leaves {}, with what a diagnosis found {}; the sensors’ noise alone would leave {}.",
        left(*heldout_rms_before),
        left(*heldout_rms_after),
        left(*noise_floor_rms)
    );
    html! {
        @match verdict {
            Verdict::None => { strong { "Nothing" } " that a diagnosis can name. " },
            Verdict::Effects => {
                @for (index, effect) in effects.iter().enumerate() { @if index > 0 { ", " } strong { code { (effect) } } }
                ". "
            },
            Verdict::OutsideLibrary => { strong { "Something without a name." } " " },
        }
        (from)
    }
}

fn method(limits: &RenderingLimits) -> Markup {
    html! {
        p {
            "A hand on the rig took the rendered knob through a sweep, another motion and a slow creep, and held it; each was \
             captured as of any other knob, by torque sensor and encoder, with nothing known of the rendering. The sweep is \
             fitted; what the knob bears at rest comes from the creep. A parameter passes if its 95 % interval holds the intended \
             value, or if it differs by at most " (three(limits.difference_percent)) " %, what the knob bears at rest by at most "
            (three(limits.static_difference_percent)) " %. Of a phase the difference is the part of a period."
        }
        p {
            "The torque error compares row by row: what the captured torque was against what the intended model asks for in \
             the captured motion. A diagnosis that begins with the intended model then looks for what the rendering has besides, \
             judged by the motion that nothing was fitted to."
        }
    }
}
