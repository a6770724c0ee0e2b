//! An effect beside every other one in its place.

use identification::diagnosis::{Diagnosis, Rival, Step};
use maud::{Markup, html};

use super::maps::probability;
use crate::figures::{Figure, Mark, real};
use crate::numbers::three;
use crate::plot::ink::Ink;
use crate::plot::{Axis, short};

/// Size of the plot, and where its dots and its columns of figures lie, SVG units.
const WIDTH: f64 = 880.0;
const LEFT: f64 = 186.0;
const RIGHT: f64 = 592.0;
const COLUMNS: [f64; 3] = [672.0, 784.0, 880.0];
/// Height of a row and of the head, SVG units.
const ROW: f64 = 21.0;
const HEAD: f64 = 24.0;
const FOOT: f64 = 44.0;
/// Round values along the axis.
const TICKS: usize = 6;
/// Length of the axis, as a multiple of the largest RMS shown.
const ROOM: f64 = 1.15;

struct Line {
    name: String,
    class: &'static str,
    rms_mnm: f64,
    evidence: Option<f64>,
    probability: Option<f64>,
}

/// Held-out RMS with the effect, with each rival and with the null effect.
pub(super) fn figure(found: &Diagnosis, step: &Step) -> Figure {
    Figure {
        title: "Every effect in its place".to_owned(),
        legend: vec![
            (Mark::Dots, Ink::After, "the effect that was added"),
            (Mark::Dots, Ink::Reference, "a tie"),
            (Mark::Dots, Ink::Measured, "a rival, hollow if it is ruled out"),
            (Mark::Line, Ink::Before, "nothing added"),
            (Mark::Line, Ink::Label, "null effect"),
            (Mark::Band, Ink::Floor, "noise floor"),
        ],
        plot: plot(found, step),
        caption: format!(
            "The further left a dot, the more of the held-out gap the effect closes. An effect that ends at the line of nothing added \
             ({} mNm) explains nothing of another motion; one beyond it explains the training capture by chance. As much freedom \
             as that of {}, spent on nothing, ends at the null effect's line ({} mNm). Best evidence first.",
            three(step.heldout_rms_before),
            step.effect,
            three(step.placebo_rms)
        ),
    }
}

fn lines(step: &Step) -> Vec<Line> {
    let rest: f64 = step.rivals.iter().map(|rival| rival.probability).sum();
    let chosen = Line {
        name: step.effect.to_owned(),
        class: "chosen",
        rms_mnm: step.heldout_rms_after,
        evidence: Some(step.evidence),
        probability: Some((1.0 - rest).clamp(0.0, 1.0)),
    };
    let rival = |rival: &Rival| {
        let tied = step.ties.contains(&rival.effect);
        let (class, mark) = match (&rival.disqualified, tied) {
            (Some(_), _) => ("ruled-out", " †"),
            (None, true) => ("tie", " (tie)"),
            (None, false) => ("rival", ""),
        };
        Line {
            name: format!("{}{mark}", rival.effect),
            class,
            rms_mnm: rival.heldout_rms_after,
            evidence: Some(rival.evidence),
            probability: Some(rival.probability),
        }
    };
    let null = Line {
        name: "null effect".to_owned(),
        class: "ruled-out",
        rms_mnm: step.placebo_rms,
        evidence: None,
        probability: None,
    };
    [chosen].into_iter().chain(step.rivals.iter().map(rival)).chain([null]).collect()
}

fn plot(found: &Diagnosis, step: &Step) -> Markup {
    let lines = lines(step);
    let marks = [step.heldout_rms_before, step.placebo_rms, step.heldout_rms_after, found.noise_floor_rms];
    let reach = ROOM * marks.into_iter().filter(|level| level.is_finite()).fold(0.0, f64::max).max(f64::MIN_POSITIVE);
    let axis = Axis::exactly("", 0.0, reach);
    let x = |level: f64| LEFT + axis.share(level).clamp(0.0, 1.0) * (RIGHT - LEFT);
    let bottom = HEAD + ROW * real(lines.len());
    html! {
        svg.plot.rivals xmlns="http://www.w3.org/2000/svg" viewBox={"0 0 " (WIDTH) " " (bottom + FOOT)} role="img"
            aria-label={"Held-out RMS with " (step.effect) " and with each rival"} {
            @for (at, words) in COLUMNS.into_iter().zip(["RMS (mNm)", "evidence (nats)", "probability"]) {
                text.title x=(at) y="12" text-anchor="end" { (words) }
            }
            @for (at, label) in axis.ticks(TICKS) {
                path.line.grid d={"M" (short(x(at))) " " (HEAD) "V" (short(bottom))} {}
                text.label x=(short(x(at))) y=(short(bottom + 16.0)) text-anchor="middle" { (label) }
            }
            text.title x=(short(0.5 * (LEFT + RIGHT))) y=(short(bottom + 36.0)) text-anchor="middle" {
                "RMS left of the held-out capture (mNm)"
            }
            @if found.noise_floor_rms.is_finite() {
                path.area.floor d={"M" (LEFT) " " (HEAD) "H" (short(x(found.noise_floor_rms))) "V" (short(bottom)) "H" (LEFT) "Z"} {}
            }
            @if step.heldout_rms_before.is_finite() {
                path.line.before d={"M" (short(x(step.heldout_rms_before))) " " (HEAD) "V" (short(bottom))} {}
            }
            @if step.placebo_rms.is_finite() {
                path.line.label.dashed d={"M" (short(x(step.placebo_rms))) " " (HEAD) "V" (short(bottom))} {}
            }
            @for (index, line) in lines.iter().enumerate() {
                (row(line, HEAD + ROW * (real(index) + 0.5), &x, (reach, step.heldout_rms_before)))
            }
        }
    }
}

fn row(line: &Line, y: f64, x: &impl Fn(f64) -> f64, (reach, before_mnm): (f64, f64)) -> Markup {
    let level = y + 4.2;
    html! {
        text class={"name " (line.class)} x=(LEFT - 12.0) y=(short(level)) text-anchor="end" { (line.name) }
        @if line.rms_mnm.is_finite() {
            @if before_mnm.is_finite() {
                path.line.thread d={"M" (short(x(before_mnm))) " " (short(y)) "H" (short(x(line.rms_mnm)))} {}
            }
            @if line.rms_mnm > reach {
                path class={"beyond " (line.class)} d={"M" (short(RIGHT - 2.0)) " " (short(y - 5.0)) "l8 5l-8 5Z"} {}
            } @else {
                circle class={"dot " (line.class)} cx=(short(x(line.rms_mnm))) cy=(short(y)) r="4.5" {}
            }
        }
        text class={"figure " (line.class)} x=(COLUMNS[0]) y=(short(level)) text-anchor="end" { (three(line.rms_mnm)) }
        @if let Some(evidence) = line.evidence {
            text class={"figure " (line.class)} x=(COLUMNS[1]) y=(short(level)) text-anchor="end" { (three(evidence)) }
        }
        @if let Some(p) = line.probability {
            text class={"figure " (line.class)} x=(COLUMNS[2]) y=(short(level)) text-anchor="end" { (share(p)) }
        }
    }
}

fn share(p: f64) -> String {
    if p > 0.999 { "> 0.999".to_owned() } else { probability(p) }
}
