//! What is left of both captures after each step.

use identification::diagnosis::Diagnosis;
use maud::{Markup, html};

use crate::figures::{Figure, Mark, real};
use crate::numbers::three;
use crate::plot::ink::Ink;
use crate::plot::{Axis, short};

/// Size of the plot and its rooms for labels, SVG units.
const WIDTH: f64 = 880.0;
const LEFT: f64 = 46.0;
const TOP: f64 = 26.0;
const FLOOR: f64 = 236.0;
const HEIGHT: f64 = 300.0;
/// Round values along the axis.
const TICKS: usize = 8;

struct Stage {
    name: String,
    heldout_mnm: f64,
    train_mnm: f64,
}

/// A stair for each step, down to the noise floor.
pub(super) fn figure(found: &Diagnosis) -> Figure {
    let mut stages: Vec<Stage> = found
        .steps
        .first()
        .map(|first| Stage {
            name: "first model".to_owned(),
            heldout_mnm: first.heldout_rms_before,
            train_mnm: first.train_rms_before,
        })
        .into_iter()
        .collect();
    stages.extend(found.steps.iter().map(|step| Stage {
        name: format!("+ {}", step.effect),
        heldout_mnm: step.heldout_rms_after,
        train_mnm: step.train_rms_after,
    }));
    Figure {
        title: "RMS that is left after each step".to_owned(),
        legend: vec![
            (Mark::Line, Ink::After, "held-out capture"),
            (Mark::Line, Ink::Measured, "training capture"),
            (Mark::Band, Ink::Floor, "noise floor"),
        ],
        plot: plot(&stages, found.noise_floor_rms),
        caption: format!(
            "Each stair is an effect more. A real effect takes both captures down, though it was fitted to one; the way ends at the \
             noise floor of {} mNm if nothing else is missing.",
            three(found.noise_floor_rms)
        ),
    }
}

fn plot(stages: &[Stage], floor_mnm: f64) -> Markup {
    let levels = stages.iter().flat_map(|stage| [stage.heldout_mnm, stage.train_mnm]).chain([floor_mnm]);
    let highest = levels.filter(|level| level.is_finite()).fold(0.0, f64::max);
    let axis = Axis::exactly("", 0.0, 1.08 * highest.max(f64::MIN_POSITIVE));
    let y = |level: f64| FLOOR - axis.share(level) * (FLOOR - TOP);
    let wide = (WIDTH - LEFT) / real(stages.len().max(1));
    let left = |index: usize| LEFT + real(index) * wide;
    html! {
        svg.plot xmlns="http://www.w3.org/2000/svg" viewBox={"0 0 " (WIDTH) " " (HEIGHT)} role="img"
            aria-label="RMS left of both captures after each step" {
            text.title x="0" y="10" { "RMS (mNm)" }
            @for (at, label) in axis.ticks(TICKS) {
                path.line.grid d={"M" (LEFT) " " (short(y(at))) "H" (WIDTH)} {}
                text.label x=(LEFT - 7.0) y=(short(y(at))) dy="0.35em" text-anchor="end" { (label) }
            }
            @if floor_mnm.is_finite() {
                path.area.floor d={"M" (LEFT) " " (short(y(floor_mnm))) "H" (WIDTH) "V" (FLOOR) "H" (LEFT) "Z"} {}
            }
            (stair(stages, "measured", |stage| stage.train_mnm, &left, &y))
            (stair(stages, "after", |stage| stage.heldout_mnm, &left, &y))
            @for (index, stage) in stages.iter().enumerate() {
                @let middle = short(left(index) + 0.5 * wide);
                text.title x=(middle) y=(FLOOR + 20.0) text-anchor="middle" { (stage.name) }
                text.label x=(middle) y=(FLOOR + 38.0) text-anchor="middle" { "held out " (three(stage.heldout_mnm)) " mNm" }
                text.label x=(middle) y=(FLOOR + 54.0) text-anchor="middle" { "training " (three(stage.train_mnm)) " mNm" }
            }
        }
    }
}

fn stair(
    stages: &[Stage],
    class: &str,
    of: impl Fn(&Stage) -> f64,
    left: &impl Fn(usize) -> f64,
    y: &impl Fn(f64) -> f64,
) -> Markup {
    let finite: Vec<(usize, f64)> = stages.iter().map(of).enumerate().filter(|(_, level)| level.is_finite()).collect();
    let mut path = String::new();
    for (index, level) in finite {
        let start = if path.is_empty() { format!("M{}", short(left(index))) } else { "V".to_owned() };
        let separator = if path.is_empty() { " " } else { "" };
        path.push_str(&format!("{start}{separator}{}H{}", short(y(level)), short(left(index + 1))));
    }
    html! { @if !path.is_empty() { path class={"line stair " (class)} d=(path) {} } }
}
