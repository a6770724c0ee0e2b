//! How large the gap is, before and after.

use identification::diagnosis::{Diagnosis, FLOOR_IS_DOUBTFUL, ForwardFromCommand, Row, Verdict};
use identification::statistics::NORMAL_95;
use maud::{Markup, html};

use super::{Numbering, floors};
use crate::figures::{Figure, Mark, Numbers, RESIDUAL, TIME, WIDE, longest_step_s, rms, typical_excerpt};
use crate::numbers::{three, two};
use crate::page::FEWEST_ROWS;
use crate::plot::ink::Ink;
use crate::plot::{Axis, Layer, Plot};

/// The section, and the numbers in its figure's caption.
pub(super) fn section(found: &Diagnosis, heldout: &[Row], numbers: &mut Numbering) -> (Markup, Numbers) {
    let drawn = (heldout.len() >= FEWEST_ROWS).then(|| excerpt(found, heldout));
    let markup = html! {
        (table(found))
        @if found.is_floor_doubtful() {
            p.note { (FLOOR_IS_DOUBTFUL) }
        }
        (from_command(found))
        @if let Some((figure, _)) = &drawn {
            (figure.numbered(numbers.next()))
        } @else {
            p.note { "Too few rows of sliding motion in the held-out capture for a plot." }
        }
    };
    (markup, drawn.map_or_else(Numbers::new, |(_, numbers)| numbers))
}

/// How the motion that follows from the command comes closer with each effect.
fn from_command(found: &Diagnosis) -> Markup {
    let Some(forward) = &found.forward_from_command else { return html! {} };
    let motor = &forward.motor;
    html! {
        p.note {
            "Motion from the command, started anew every " (three(forward.window_s)) " s: the first model errs by "
            @for (index, error) in forward.angle_rms_rad.iter().enumerate() {
                @if index > 0 {
                    ", with " @if let Some(step) = found.steps.get(index - 1) { code { (step.effect) } } " by "
                }
                (three(*error)) " rad"
            }
            " RMS. The rig's motor has an inertia of " (three(motor.inertia)) " mNm s²/rad by calibration; of the command its friction \
             takes " (three(motor.coulomb_mnm)) " mNm and " (three(motor.viscous)) " mNm s/rad, as the training capture shows."
        }
    }
}

fn table(found: &Diagnosis) -> Markup {
    let changed = !found.steps.is_empty();
    let [percent_before, percent_after] = found.heldout_relative_error_percent;
    let row = |name: &str, unit: &str, [before, after]: [f64; 2], is_rms: bool| {
        html! {
            tr {
                th scope="row" { (name) }
                td.number { (three(before)) @if is_rms { span.faint { (floors(found, before)) " × noise" } } }
                @if changed {
                    td.number.value { (three(after)) @if is_rms { span.faint { (floors(found, after)) " × noise" } } }
                    td.number { (two(before / after)) " ×" }
                }
                td.unit { (unit) }
            }
        }
    };
    let left = "RMS left of the held-out capture";
    html! {
        div.scroll {
            table.gap {
                thead {
                    tr {
                        th { "" }
                        th.number { (if changed { "first model" } else { "model" }) }
                        @if changed { th.number { "with what was added" } th.number { "smaller by" } }
                        th { "unit" }
                    }
                }
                tbody {
                    (row(left, "mNm", [found.heldout_rms_before, found.heldout_rms_after], true))
                    (row("the same, of the measured torque", "%", [percent_before, percent_after], false))
                    (row("RMS left of the training capture", "mNm", [found.train_rms_before, found.train_rms_after], false))
                    @if let Some(forward) = found.forward_angle_rms_rad {
                        (row("RMS error of the held-out angle predicted from the measured torque over 0.1 s", "rad", forward, false))
                    }
                    @if let Some(forward) = found.forward_from_command.as_ref().and_then(ForwardFromCommand::before_and_after_rad) {
                        (row("the same, predicted from the torque commanded from the motor", "rad", forward, false))
                    }
                    tr {
                        th scope="row" { "RMS that noise alone leaves of the held-out capture" }
                        td.number { (three(found.noise_floor_rms)) }
                        @if changed { td {} td {} }
                        td.unit { "mNm" }
                    }
                }
            }
        }
    }
}

/// The residual of the held-out capture in a stretch that is typical of the gap.
fn excerpt(found: &Diagnosis, rows: &[Row]) -> (Figure, Numbers) {
    let changed = !found.steps.is_empty();
    let shown = typical_excerpt(rows, |row| row.t_s, |row| row.residual_before_mnm);
    let (start_s, end_s) = (shown.first().map_or(0.0, |row| row.t_s), shown.last().map_or(0.0, |row| row.t_s));
    let reach = NORMAL_95 * found.noise_floor_rms;
    let longest_s = longest_step_s(rows, |row| row.t_s);
    let mut layers = vec![
        Layer::Band(Ink::Floor, vec![(start_s, -reach, reach), (end_s, -reach, reach)]),
        Layer::Level(Ink::Zero, 0.0),
    ];
    let mut lines = |ink: Ink, of: fn(&Row) -> f64| {
        for run in shown.chunk_by(|a, b| b.t_s - a.t_s <= longest_s) {
            layers.push(Layer::Line(ink, run.iter().map(|row| (row.t_s, of(row))).collect()));
        }
    };
    if changed {
        lines(Ink::Before, |row| row.residual_before_mnm);
    }
    lines(Ink::After, |row| row.residual_after_mnm);
    let both = shown.iter().flat_map(|row| [row.residual_before_mnm, row.residual_after_mnm]);
    let plot = Plot {
        size: WIDE,
        x: Axis::exactly(TIME, start_s, end_s),
        y: Axis::around(RESIDUAL, both.chain([1.1 * reach, -1.1 * reach])),
        layers,
    };
    let mut legend = if changed {
        vec![
            (Mark::Line, Ink::Before, "the first model's residual"),
            (Mark::Line, Ink::After, "the final model's residual"),
        ]
    } else {
        vec![(Mark::Line, Ink::After, "the model's residual")]
    };
    legend.push((Mark::Band, Ink::Floor, "95 % of the sensors' noise"));
    let seen = match found.verdict {
        Verdict::None => "The line fills the band and shows no shape: that is what noise looks like.",
        Verdict::Effects => {
            "Where the first model's line leaves the band with a shape, something is missing; the final model's line should stay \
             within the band and have no shape left."
        }
        Verdict::OutsideLibrary => {
            "The shape that still stands out of the band is what no effect of the catalogue explains."
        }
    };
    let whose = if changed { "the first model's" } else { "the" };
    let residual_rms_mnm = rms(shown.iter().map(|row| row.residual_before_mnm));
    let figure = Figure {
        title: "Measured minus model, held out".to_owned(),
        legend,
        plot: plot.svg("Residual of the held-out capture over time, before and after"),
        caption: format!(
            "{seen} {} s from t = {} s, chosen because {whose} residual there ({} mNm RMS) is most like that of the \
             whole capture. Band: ± {} mNm. Gaps are where the knob was too slow to be surely sliding.",
            two(end_s - start_s),
            three(start_s),
            three(residual_rms_mnm),
            three(reach)
        ),
    };
    let numbers = [
        ("start_s", start_s),
        ("duration_s", end_s - start_s),
        ("residual_rms_mnm", residual_rms_mnm),
        ("band_mnm", reach),
    ];
    (figure, numbers.into())
}
