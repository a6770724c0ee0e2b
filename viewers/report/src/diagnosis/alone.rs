//! An effect by itself, over the quantity that its torque goes with.

use std::f64::consts::TAU;

use dynamics::{Model, Motion, Part};
use identification::Point;
use identification::diagnosis::{Diagnosis, Row, Step};

use crate::figures::{Figure, TORQUE_LEGEND, quantity_plot, real};
use crate::page::FEWEST_ROWS;

/// Bins in which a quantity is tried, for each direction.
const BINS: usize = 120;
/// Share of the torque's variance that a quantity must explain to be worth a plot over it.
const EXPLAINED: f64 = 0.9;

/// Torque of the effect as measured, that is what the rest of the model leaves, and as fitted; `None` for an effect with a
/// memory, or one whose torque is no curve over a single quantity.
pub(super) fn figure(found: &Diagnosis, step: &Step, rows: &[Row]) -> Option<Figure> {
    let torques_mnm = torques_mnm(&found.model, step.effect, rows)?;
    if rows.len() < FEWEST_ROWS {
        return None;
    }
    let period_rad = found.model.parameter("detent_period").filter(|period| *period != 0.0);
    let mut quantities: Vec<(&str, Vec<f64>)> = vec![
        ("angle (rad)", rows.iter().map(|row| row.angle_rad).collect()),
        ("velocity (rad/s)", rows.iter().map(|row| row.velocity_rad_s).collect()),
        ("t (s)", rows.iter().map(|row| row.t_s).collect()),
    ];
    if let Some(period_rad) = period_rad {
        let within = |row: &Row| row.angle_rad.rem_euclid(TAU * period_rad.abs());
        quantities.push(("angle within a detent (rad)", rows.iter().map(within).collect()));
    }
    let explained = |at: &[f64]| explained(rows, at, &torques_mnm);
    let (title, at) = quantities.into_iter().max_by(|a, b| explained(&a.1).total_cmp(&explained(&b.1)))?;
    if explained(&at) < EXPLAINED {
        return None;
    }
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

/// The effect's share of the model's torque in every row, mNm.
fn torques_mnm(model: &Model, name: &str, rows: &[Row]) -> Option<Vec<f64>> {
    let effect = model.effect(name)?;
    let without = Model {
        effects: model.effects.iter().filter(|other| other.kind().name != name).copied().collect(),
        ..model.clone()
    };
    let share = |motion: &Motion| match effect.kind().part {
        Part::Reading(reading) => Some(reading(effect.values(), motion)),
        Part::Torque(_) | Part::Friction(_) | Part::CoulombFactor(_) | Part::FrictionFactor(_) => {
            Some(model.torque_mnm(motion) - without.torque_mnm(motion))
        }
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

/// Share of the torque's variance that its mean in bins of a quantity, by direction, explains; 0 for a torque that does not
/// vary.
fn explained(rows: &[Row], at: &[f64], torques_mnm: &[f64]) -> f64 {
    let low = at.iter().copied().fold(f64::INFINITY, f64::min);
    let high = at.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut bins = vec![[0.0; 3]; 2 * (BINS + 1)];
    let mut all = [0.0; 3];
    for ((row, at), torque) in rows.iter().zip(at).zip(torques_mnm) {
        let share = if high > low { (at - low) / (high - low) } else { 0.0 };
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a share of the number of bins")]
        let bin = (share * real(BINS)) as usize;
        for sums in [&mut bins[2 * bin + usize::from(row.velocity_rad_s > 0.0)], &mut all] {
            *sums = [sums[0] + 1.0, sums[1] + torque, sums[2] + torque * torque];
        }
    }
    let scatter =
        |[count, sum, squares]: [f64; 3]| if count > 0.0 { (squares - sum * sum / count).max(0.0) } else { 0.0 };
    let total = scatter(all);
    // Rounding alone makes a constant torque scatter.
    if total <= 1e-12 * all[2] { 0.0 } else { 1.0 - bins.into_iter().map(scatter).sum::<f64>() / total }
}
