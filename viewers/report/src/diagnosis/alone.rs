//! An effect by itself, over the quantity that its torque goes with.

use std::f64::consts::TAU;

use dynamics::{Coordinate, Effect, Model, Motion, Part, Role, effects};
use identification::Point;
use identification::diagnosis::{Diagnosis, Row, Step};

use crate::figures::{Figure, TORQUE_LEGEND, quantity_plot};
use crate::page::FEWEST_ROWS;

/// Bins of the plotted quantity, for each direction.
const BINS: usize = 120;

/// Torque of the effect as measured, which is what the rest of the model leaves, and as fitted; `None` for an effect with a
/// memory, or one whose torque is no curve over a single quantity.
pub(super) fn figure(found: &Diagnosis, step: &Step, rows: &[Row]) -> Option<Figure> {
    let torques_mnm = torques_mnm(&found.model, step.effect, rows)?;
    if rows.len() < FEWEST_ROWS {
        return None;
    }
    let (title, of) = quantity(found.model.effect(step.effect)?, &found.model)?;
    let at: Vec<f64> = rows.iter().map(of).collect();
    let point = |((row, at), torque_mnm): ((&Row, &f64), &f64)| Point {
        t_s: row.t_s,
        // The quantity of the plot stands in the angle's place.
        angle_rad: *at,
        velocity_rad_s: row.velocity_rad_s,
        acceleration_rad_s2: 0.0,
        torque_mnm: torque_mnm + row.residual_after_mnm,
        torque_model_mnm: *torque_mnm,
        torque_model_ci95_mnm: 0.0,
        residual_mnm: row.residual_after_mnm,
    };
    let points: Vec<Point> = rows.iter().zip(&at).zip(&torques_mnm).map(point).collect();
    Some(Figure {
        title: format!("The torque of {} by itself", step.effect),
        legend: TORQUE_LEGEND.to_vec(),
        plot: quantity_plot(&points, title, |point| point.angle_rad, (BINS, 6))
            .svg(&format!("Torque of {} over {title}", step.effect)),
        caption: format!(
            "Dots: the held-out torque less everything in the final model but {}. Lines: the effect as fitted to the training \
             capture. Dots that follow the lines are the effect at work in a motion that it was not fitted to.",
            step.effect
        ),
    })
}

/// Reads a quantity off a row.
type Quantity = Box<dyn Fn(&Row) -> f64>;

/// The main quantity that the effect declares to depend on, with its axis; for an effect that repeats with the detents, an angle
/// within a detent.
fn quantity(effect: &Effect, model: &Model) -> Option<(&'static str, Quantity)> {
    let period_rad = model.parameter("detent_period").filter(|period| *period != 0.0);
    let kind = effect.kind();
    let repeats = kind.role == Role::Detents && kind.name != effects::cogging::KIND.name;
    match (kind.depends_on.first()?, period_rad.filter(|_| repeats)) {
        (Coordinate::Angle, Some(period_rad)) => Some((
            "angle within a detent (rad)",
            Box::new(move |row: &Row| row.angle_rad.rem_euclid(TAU * period_rad.abs())),
        )),
        (Coordinate::Angle, None) => Some(("angle (rad)", Box::new(|row: &Row| row.angle_rad))),
        (Coordinate::Velocity, _) => Some(("velocity (rad/s)", Box::new(|row: &Row| row.velocity_rad_s))),
        // What hums has hundreds of periods in a capture.
        (Coordinate::Time, _) if matches!(kind.part, Part::Reading(_)) => None,
        (Coordinate::Time, _) => Some(("t (s)", Box::new(|row: &Row| row.t_s))),
        (Coordinate::Acceleration | Coordinate::Load, _) => None,
    }
}

/// The effect's share of the model's torque in every row, mNm.
fn torques_mnm(model: &Model, name: &str, rows: &[Row]) -> Option<Vec<f64>> {
    let effect = model.effect(name)?;
    let without = Model {
        effects: model.effects.iter().filter(|other| other.kind().name != name).copied().collect(),
        ..model.clone()
    };
    let share = |motion: &Motion| match effect.kind().part {
        Part::Reading(reading) => Some(reading(effect.values(), motion)),
        Part::Torque(_)
        | Part::TorqueTable(_)
        | Part::Friction(_)
        | Part::FrictionTable(_)
        | Part::CoulombFactor(_)
        | Part::FrictionFactor(_) => Some(model.torque_mnm(motion) - without.torque_mnm(motion)),
        _ => None,
    };
    let motion = |row: &Row| Motion {
        time_s: row.t_s,
        angle_rad: row.angle_rad,
        velocity_rad_s: row.velocity_rad_s,
        acceleration_rad_s2: 0.0,
    };
    rows.iter().map(|row| share(&motion(row)).filter(|torque_mnm| torque_mnm.is_finite())).collect()
}
