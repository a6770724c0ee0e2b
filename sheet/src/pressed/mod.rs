//! Pressed controls: domes, switches, buttons.

mod contact;
mod features;
mod figures;
mod stroke;

pub(crate) use figures::KINDS;
pub(crate) use stroke::Stroke;

use std::collections::BTreeMap;

use archive::testers::Curve;
use identification::statistics::{NORMAL_95, range, rms};

use crate::branch::Branch;
use crate::figure::{Estimate, FigureKind};
use crate::noise::{DRAWS, Signs, mean_and_deviation};
use crate::repeats::CurveError;
use contact::Change;
use features::features;
use figures::{CONTACT_CLOSING_BOUNCE, CONTACT_HYSTERESIS, CONTACT_OPENING_BOUNCE};
use stroke::{STEP_MM, smoothed};

/// The residual about a mean over seven rows lacks a seventh of the noise's variance: √(7/6) restores it.
const UNTAKEN: f64 = 1.080_123_449_734_643_6;
/// Fewest steps of a press.
const FEWEST_STEPS: usize = 40;
/// Longest travel of a control, mm.
const LONGEST_MM: f64 = 5_000.0;

/// What one press and its return tell.
pub(crate) struct Pressed {
    pub(crate) figures: BTreeMap<&'static str, Result<Estimate, &'static str>>,
    pub(crate) branches: Vec<(&'static str, Branch)>,
}

/// Reads the figures off each press of a curve, with the errors that the curve's noise makes.
///
/// # Errors
/// [`CurveError::NoPress`] where there is next to no travel to press over, [`CurveError::TooFar`] for more than any control has.
pub(crate) fn read(curve: &Curve) -> Result<Vec<Pressed>, CurveError> {
    let [low, high] = range(&curve.position);
    if high - low > LONGEST_MM {
        return Err(CurveError::TooFar { travel_mm: high - low });
    }
    let strokes = Stroke::all(curve);
    if strokes.is_empty() || strokes.iter().any(|stroke| stroke.press.len() < FEWEST_STEPS) {
        return Err(CurveError::NoPress);
    }
    Ok(strokes.into_iter().map(of_stroke).collect())
}

fn of_stroke(mut stroke: Stroke) -> Pressed {
    let values = features(&stroke);
    let deviations = deviations(&stroke, &values);
    let figures = values.iter().map(|(kind, value)| {
        let estimate = value.map(|value| {
            // A place along the travel is known to a step at best.
            let places = if *kind == &CONTACT_HYSTERESIS { 2.0 } else { f64::from(u8::from(kind.unit == "mm")) };
            let step = STEP_MM * (places / 12.0).sqrt();
            Estimate { value, standard_error: deviations.get(kind.name).copied().unwrap_or(0.0).hypot(step) }
        });
        (kind.name, estimate)
    });
    let bounce = |change: &Result<Change, &'static str>| change.as_ref().map_err(|reason| *reason)?.bounce_ms;
    let bounces = [(&CONTACT_CLOSING_BOUNCE, &stroke.closing), (&CONTACT_OPENING_BOUNCE, &stroke.opening)];
    let figures = figures.chain(bounces.map(|(kind, change)| (kind.name, bounce(change)))).collect();
    for branch in [Some(&mut stroke.press), stroke.back.as_mut()].into_iter().flatten() {
        let left = rms(&smooth_and_left(branch).1);
        branch.load_ci95_half_width.fill(NORMAL_95 * left);
    }
    let branches = [("press", Some(stroke.press)), ("return", stroke.back)];
    let branches = branches.into_iter().filter_map(|(name, branch)| Some((name, branch?))).collect();
    Pressed { figures, branches }
}

/// The smoothed branch, and what it leaves.
fn smooth_and_left(branch: &Branch) -> (Vec<f64>, Vec<f64>) {
    let smooth = smoothed(&branch.load);
    let left = branch.load.iter().zip(&smooth).map(|(load, smooth)| (load - smooth) * UNTAKEN).collect();
    (smooth, left)
}

/// Standard deviations of the figures, as the noise about the smoothed curve makes them.
fn deviations(
    stroke: &Stroke,
    values: &[(&'static FigureKind, Result<f64, &'static str>)],
) -> BTreeMap<&'static str, f64> {
    let mut signs = Signs::new();
    let press = smooth_and_left(&stroke.press);
    let back = stroke.back.as_ref().map(smooth_and_left);
    let mut drawn: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
    for _ in 0..DRAWS {
        let mut again = stroke.clone();
        again.press.load = signs.redraw(&press.0, &press.1);
        if let (Some(branch), Some((smooth, left))) = (&mut again.back, &back) {
            branch.load = signs.redraw(smooth, left);
        }
        for (kind, value) in features(&again) {
            if let Ok(value) = value {
                drawn.entry(kind.name).or_default().push(value);
            }
        }
    }
    values.iter().filter_map(|(kind, _)| Some((kind.name, mean_and_deviation(drawn.get(kind.name)?)?.1))).collect()
}
