//! Measures torques without a name: a spline of the residual over one coordinate, kept if it predicts stretches of another
//! capture, to which it was not fitted.

use std::f64::consts::TAU;

use dynamics::{Coordinate, effects};
use rayon::prelude::*;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::Characteristic;
use crate::diagnosis::model_fit::separable::Separable;
use crate::diagnosis::search::acceptance::{FALSE_DISCOVERIES, LEFT, takes_its_part};
use crate::diagnosis::search::found::Found;
use crate::diagnosis::search::judged::Judged;
use crate::diagnosis::search::{Search, null_test};
use crate::numerics::statistics::{NORMAL_95, false_discovery_rate, interval};
use crate::regression::characteristic::{CharacteristicPoint, Spline, holds};
use crate::regression::least_squares::LeastSquares;

/// Points of a spline that are tried: a scratch over a twentieth of the travel needs many.
const POINTS: [u16; 4] = [8, 16, 32, 64];
/// Most characteristics of one model.
const MOST: usize = 2;
/// Ridge that holds a point near zero if the capture hardly shows it, as a share of the mean point's square; a torque that the
/// named effects can explain too goes to these.
const HELD: f64 = 1e-3;
/// Rounds in which a bend and the detents on it are fitted in turn.
const BEND_ROUNDS: usize = 3;
/// Travel in turns from which a rest may repeat with every turn.
const TURNS: f64 = 1.1;

/// All splines that a capture could show.
fn all_splines(capture: &Capture) -> Vec<Spline> {
    let scene = &capture.scene;
    let turns = scene.is_rotary && scene.travel_rad() > TURNS * TAU;
    let over_angle = [effects::angle_characteristic::KIND.name, effects::friction_characteristic::KIND.name];
    let mut all = Vec::new();
    for kind in effects::ALL {
        if over_angle.contains(&kind.name) {
            all.push((kind, [scene.lowest_rad, scene.highest_rad], None));
            all.extend(turns.then_some((kind, [0.0, TAU], Some(TAU))));
        } else if kind.name == effects::speed_characteristic::KIND.name && !capture.is_map {
            all.push((kind, [0.0, scene.highest_speed_rad_s], None));
        }
    }
    let splines = all
        .into_iter()
        .flat_map(|(kind, range, period_rad)| POINTS.map(|count| Spline::new(kind, range, count, period_rad)));
    splines.flatten().collect()
}

/// Name of the coordinate that a spline lies over, as in [`Location`](crate::diagnosis::Location).
fn coordinate(spline: &Spline) -> &'static str {
    match (spline.of.over, spline.period_rad) {
        (Coordinate::Velocity, _) => "velocity",
        (_, Some(_)) => "angle-within-turn",
        _ => "angle",
    }
}

/// Rows of the torque of every point alone, 1 mNm high.
fn rows(spline: &Spline, capture: &Capture) -> Vec<Vec<f64>> {
    let columns = spline.columns(capture.motion.len(), |index| capture.motion.at(index));
    columns.map(|column| capture.row_filter.rows(&column)).collect()
}

impl Search<'_> {
    /// Adds torques without a name to the model, one characteristic after the other, while they predict the held-out capture.
    pub(crate) fn measure_the_rest(&self, found: &mut Found) {
        while found.characteristics.len() < MOST {
            let current = found.last().clone();
            let over_floor = current.train_over_floor().min(current.heldout_over_floor());
            if current.structure.is_coupled() || over_floor < LEFT {
                return;
            }
            let Some((judged, characteristic)) = self.best_characteristic(&current, found) else { return };
            found.characteristics.push((judged, characteristic));
        }
    }

    /// The fit with a torque that bends slowly along the angle.
    pub(crate) fn bent(&self, current: &Judged) -> Option<Judged> {
        let scene = &self.train.scene;
        let [.., finest] = POINTS;
        let range = [scene.lowest_rad, scene.highest_rad];
        let spline = Spline::new(&effects::angle_characteristic::KIND, range, finest, None)?;
        let mut best = current.clone();
        // The detents shift once the bend is fitted, so the two are fitted in turn.
        for _ in 0..BEND_ROUNDS {
            let straight = match best.structure.position(spline.kind.name) {
                Some(index) => best.structure.without(index),
                None => best.structure,
            };
            let bend = Separable::new(straight.clone(), self.train).bend();
            let torque_mnm: Vec<f64> = spline.points.iter().map(|angle_rad| bend(*angle_rad)).collect();
            best = self.settled(straight.with(spline.effect(&torque_mnm)?, 1));
        }
        Some(best)
    }

    /// The spline with the most evidence that predicts the held-out capture better than chance and no worse than a null test of the same freedom.
    fn best_characteristic(&self, current: &Judged, found: &Found) -> Option<(Judged, Characteristic)> {
        let present = Separable::new(current.structure.clone(), self.train);
        let mut splines = all_splines(self.train);
        let name_is_new = |spline: &Spline| current.structure.position(spline.kind.name).is_none();
        splines.retain(name_is_new);
        let settled = splines.par_iter().enumerate().filter_map(|(index, spline)| {
            let effect = spline.effect(&torques_mnm(spline, &present, self.train))?;
            Some((index, self.settled(current.structure.with(effect, 1))))
        });
        let tried: Vec<(usize, Judged)> = settled.collect();
        let p_values: Vec<f64> = tried.iter().map(|(_, judged)| judged.heldout_p_value(current)).collect();
        let mut best: Vec<(&(usize, Judged), f64)> = tried
            .iter()
            .zip(p_values.iter().map(|p_value| false_discovery_rate(*p_value, &p_values)))
            .filter(|((_, judged), rate)| *rate <= FALSE_DISCOVERIES && takes_its_part(current, judged))
            .collect();
        best.sort_by(|(one, _), (other, _)| other.1.evidence.total_cmp(&one.1.evidence));
        best.into_iter().find_map(|((index, judged), false_discovery_rate)| {
            let spline = &splines[*index];
            let [train, heldout] = [self.train, self.heldout].map(|capture| rows(spline, capture));
            let placebo_rms = null_test::rms_of_columns([&train, &heldout], current, self.heldout);
            if judged.heldout_rms_mnm > placebo_rms {
                return None;
            }
            let nearest = found.partial.iter().max_by(|a, b| a.explains_percent.total_cmp(&b.explains_percent));
            let characteristic = Characteristic {
                effect: spline.kind.name,
                coordinate: coordinate(spline),
                points: points(spline, judged, &train),
                train_rms_before: current.train_rms_mnm,
                train_rms_after: judged.train_rms_mnm,
                heldout_rms_before: current.heldout_rms_mnm,
                heldout_rms_after: judged.heldout_rms_mnm,
                false_discovery_rate,
                placebo_rms,
                nearest: nearest.map(|partial| partial.effect),
            };
            Some((judged.clone(), characteristic))
        })
    }
}

/// The torques of a spline's points, fitted beside the columns that a fit already has, mNm.
fn torques_mnm(spline: &Spline, present: &Separable<'_>, capture: &Capture) -> Vec<f64> {
    let points = rows(spline, capture);
    let target = capture.target(present.structure.delay_s());
    present.coefficients_beside(&points, &target, &holds(present.columns().len(), &points, |_| HELD))
}

/// The points of a fitted spline with their intervals, the other effects held fixed.
fn points(spline: &Spline, judged: &Judged, rows: &[Vec<f64>]) -> Vec<CharacteristicPoint> {
    let solved = LeastSquares::solve(rows, &judged.train_residual);
    let covariance = solved.robust_of_points(rows, 0);
    let effect = judged.structure.effects.last();
    let table = effect.and_then(|effect| Some((effect.values()[0], effect.table()?)));
    let point = |(index, at): (usize, &f64)| {
        let torque_mnm = table.map_or(0.0, |(scale, table)| scale * table.points_mnm()[index]);
        let half = NORMAL_95 * covariance[(index, index)].sqrt();
        let known = !solved.collinear[index] && half.is_finite();
        CharacteristicPoint { at: *at, torque_mnm, ci95: known.then(|| interval(torque_mnm, half)) }
    };
    spline.points.iter().enumerate().map(point).collect()
}
