//! The final model: its parameters, and its torque beside what was measured.

use dynamics::Model;
use identification::Point;
use identification::diagnosis::{Diagnosis, Row};
use maud::{Markup, html};

use super::Numbering;
use crate::figures::{Figure, TORQUE_LEGEND, angle_plot, velocity_plot};
use crate::numbers::Digits;
use crate::page::FEWEST_ROWS;
use crate::parameter_table::name_cells;

/// Digits of a parameter of which no interval is known here.
const DIGITS: i32 = 4;

pub(super) fn section(found: &Diagnosis, heldout: &[Row], numbers: &mut Numbering) -> Markup {
    let points: Vec<Point> = heldout.iter().map(point).collect();
    let has_detents = found.model.parameter("detent_period").is_some();
    html! {
        @if points.len() < FEWEST_ROWS {
            p.note { "Too few rows of sliding motion in the held-out capture for plots." }
        } @else {
            (angle_figure(&points, has_detents).numbered(numbers.next()))
            (velocity_figure(&points).numbered(numbers.next()))
        }
        (parameters(&found.model))
    }
}

fn point(row: &Row) -> Point {
    Point {
        t_s: row.t_s,
        angle_rad: row.angle_rad,
        velocity_rad_s: row.velocity_rad_s,
        acceleration_rad_s2: 0.0,
        torque_mnm: row.torque_mnm,
        torque_model_mnm: row.torque_mnm - row.residual_after_mnm,
        torque_model_ci95_mnm: 0.0,
        residual_mnm: row.residual_after_mnm,
    }
}

fn angle_figure(points: &[Point], has_detents: bool) -> Figure {
    Figure {
        title: "Torque against angle, held out".to_owned(),
        legend: TORQUE_LEGEND.to_vec(),
        plot: angle_plot(points, has_detents),
        caption: "Lines: the final model's torque for the held-out motion, averaged at each angle. They should run through the middle \
                  of the dots of their direction everywhere."
            .to_owned(),
    }
}

fn velocity_figure(points: &[Point]) -> Figure {
    Figure {
        title: "Torque against velocity, held out".to_owned(),
        legend: TORQUE_LEGEND.to_vec(),
        plot: velocity_plot(points),
        caption: "Lines: the same over similar velocities. The dots spread by inertia and by what depends on the angle; friction is \
                  the step at zero and the slope."
            .to_owned(),
    }
}

/// Every parameter of the model.
fn parameters(model: &Model) -> Markup {
    let zero: Vec<&str> = model.parameters().filter(|(_, value)| *value == 0.0).map(|(kind, _)| kind.name).collect();
    html! {
        @if model.effects.is_empty() {
            p.note { "The model has no effects." }
        } @else {
            div.scroll {
                table.parameters {
                    thead { tr { th { "parameter" } th { "symbol" } th.number { "value" } th { "unit" } th { "effect" } } }
                    tbody {
                        @for effect in &model.effects {
                            @for (kind, value) in effect.parameters().filter(|(_, value)| *value != 0.0) {
                                tr {
                                    (name_cells(kind.name))
                                    td.number.value { (Digits::significant(value, DIGITS).show(value)) }
                                    td.unit { (dynamics::printed_unit(kind.unit)) }
                                    td { (effect.kind().name) }
                                }
                            }
                        }
                    }
                }
            }
            p.note {
                "Four digits each, whatever the data support; the intervals of what was added are with the steps."
                @if !zero.is_empty() { " Zero and left out: " (zero.join(", ")) "." }
            }
        }
    }
}
