//! The page of a diagnosis: how large the gap is, where it lies, what closes it, and what is left.

mod alone;
mod gap;
mod left;
mod maps;
mod model;
mod rivals;
mod shape;
mod staircase;
mod steps;

use identification::diagnosis::{Diagnosis, Row, Verdict};
use maud::{Markup, html};

use crate::numbers::{count, three};
use crate::page::{document, footer, sentence};
use crate::{DiagnosisPage, FigureNumbers};

/// Numbers the figures of a page.
#[derive(Debug, Default)]
struct Numbering(usize);

impl Numbering {
    fn next(&mut self) -> usize {
        self.0 += 1;
        self.0
    }
}

/// The page, and the numbers in the captions of its figures.
pub(crate) fn diagnosis_page(page: &DiagnosisPage<'_>) -> (Markup, FigureNumbers) {
    let DiagnosisPage { found, train, heldout } = page;
    let mut numbers = Numbering::default();
    let heldout_rows = finite_rows(&found.rows[1]);
    let (gap, in_gap) = gap::section(found, &heldout_rows, &mut numbers);
    let sources: Vec<&str> =
        [Some(train), heldout.as_ref()].into_iter().flatten().map(|of| of.source.as_str()).collect();
    let content = html! {
        header {
            p.kind { "Diagnosis of a model beside captures" }
            h1 { (train.title) }
            p.verdict { (found.summary) }
            p.completeness { (meaning(found)) }
            (facts(page))
        }
        section {
            h2 { "The gap" }
            (gap)
        }
        section {
            h2 { "Where the first model and the capture disagree" }
            (maps::section(&found.locations, &mut numbers))
        }
        @for index in 0..found.steps.len() { (steps::section(found, index, &heldout_rows, &mut numbers)) }
        @if !found.steps.is_empty() {
            section {
                h2 { "The way down" }
                (staircase::figure(found).numbered(numbers.next()))
            }
        }
        section {
            h2 { "What is left" }
            (left::section(found, &mut numbers))
        }
        section {
            h2 { (if found.steps.is_empty() { "The model" } else { "The model with all that was added" }) }
            (model::section(found, &heldout_rows, &mut numbers))
        }
        section {
            h2 { "What to capture next" }
            (next_experiment(found))
        }
        @if !found.notes.is_empty() {
            section {
                h2 { "What a reader should know" }
                ul { @for note in &found.notes { li { (sentence(note)) } } }
            }
        }
        section {
            h2 { "How the numbers were made" }
            (method(found))
        }
        (footer(&train.software_version, &sources.join(" and ")))
    };
    (document(&train.title, &content), [("residual_over_time", in_gap)].into())
}

/// What the verdict means for a reader who has never seen one.
fn meaning(found: &Diagnosis) -> String {
    let judged = if found.heldout_is_own {
        "stretches of the training capture that no model was fitted to"
    } else {
        "another motion of the same knob, which no model was fitted to"
    };
    match found.verdict {
        Verdict::None => {
            format!(
                "No effect of the catalogue predicts {judged}, enough better to be named, and what is left is like noise."
            )
        }
        Verdict::Effects => {
            format!("Each effect named below was fitted to the training capture and had to predict {judged}.")
        }
        Verdict::OutsideLibrary => format!(
            "Every effect of the catalogue was tried on the training capture and judged by {judged}; none closes the gap. \
             Where the page names effects all the same, they stand for part of it and are no names of what is missing."
        ),
    }
}

fn facts(page: &DiagnosisPage<'_>) -> Markup {
    let captures = [("training capture", Some(&page.train)), ("held-out capture", page.heldout.as_ref())];
    html! {
        @for (role, capture) in captures {
            @if let Some(capture) = capture {
                dl.facts {
                    div { dt { (role) } dd { (capture.source) } }
                    div { dt { "rate" } dd { (three(capture.rate_hz)) " Hz" } }
                    div { dt { "duration" } dd { (three(capture.duration_s)) " s" } }
                    div { dt { "samples" } dd { (count(capture.samples)) } }
                    @for (name, words) in [("knob", &capture.knob), ("rig", &capture.rig), ("captured", &capture.captured_at)] {
                        @if !words.is_empty() { div { dt { (name) } dd { (words) } } }
                    }
                    div { dt { "compared below" } dd { (three(page.found.band_hz)) " Hz" } }
                }
            }
        }
    }
}

fn next_experiment(found: &Diagnosis) -> Markup {
    let Some(next) = &found.next_experiment else {
        let tied = found.steps.iter().any(|step| !step.ties.is_empty());
        return html! {
            p {
                @if tied {
                    "No excitation that was tried, within the angles and speeds of these captures, tells the tied effects apart."
                } @else if found.verdict == Verdict::OutsideLibrary {
                    "No two effects of the catalogue compete for what is missing, so no capture can be proposed to choose between them."
                } @else {
                    "Nothing: no two effects are tied, so no further capture is needed to choose between them."
                }
            }
        };
    };
    let [one, other] = &next.tells_apart;
    html! {
        p {
            "To tell " code { (one) } " from " code { (other) } ": "
            code { "--sweep " (next.excitation) " --amplitude " (format!("{:.3}", next.amplitude_rad)) }
            ", that is " (three(next.amplitude_rad)) " rad. There the two predict torques that differ by "
            (three(next.difference_rms_mnm)) " mNm RMS, " (three(next.difference_over_noise)) " times the noise: a capture of 8 s is \
             worth " (three(next.expected_evidence)) " nats."
        }
    }
}

fn method(found: &Diagnosis) -> Markup {
    html! {
        p {
            "All RMS values compare torque and model in rows: filtered below " (three(found.band_hz)) " Hz, without the moments in \
             which the knob may stick. Models are fitted to the training capture; only what belongs to a capture and not to the knob, as the phase of the mains, is \
             fitted to each. The noise floor is what the torque sensor's \
             noise, as seen while the knob rests, and the acceleration's noise times the inertia leave beside a complete model."
        }
        p {
            "The evidence of an effect is the gain in log-likelihood over the rows of both captures less the cost of its \
             parameters (Schwarz 1978), in nats: 10 nats are odds of 22\u{202f}000 to 1, if rows were independent. Since they are not \
             quite, an effect must also explain stretch after stretch better; the steadiness is the mean gain of a stretch over \
             its standard error. The null effect has the effect's own columns, shifted in time: what as much freedom buys when \
             it means nothing."
        }
        p {
            "A map is the mean residual in bins with as many rows each. Its share is the part of the residual's mean square that \
             it predicts in stretches which it was not made from; p is the probability that a map of nothing would do as well. \
             Coordinates count as significant with at most one false discovery in twenty (Benjamini and Hochberg 1995)."
        }
    }
}

/// Rows with nothing but finite numbers.
fn finite_rows(rows: &[Row]) -> Vec<Row> {
    let finite = |row: &&Row| {
        let Row { t_s, angle_rad, velocity_rad_s, torque_mnm, residual_before_mnm, residual_after_mnm } = **row;
        [t_s, angle_rad, velocity_rad_s, torque_mnm, residual_before_mnm, residual_after_mnm]
            .iter()
            .all(|value| value.is_finite())
    };
    rows.iter().filter(finite).copied().collect()
}

/// How many noise floors an RMS is.
fn floors(found: &Diagnosis, rms_mnm: f64) -> String {
    crate::numbers::two(rms_mnm / found.noise_floor_rms)
}
